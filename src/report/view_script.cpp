// SPDX-License-Identifier: Apache-2.0
#include "report/view_script.hpp"

namespace scanmill::report {

// Written for browsers back to WebGL 1. Nothing is decoded or drawn before the view comes near the screen, and then
// only when something changes. "#view=30,20,1.5,error" behind the page's name sets azimuth, elevation, zoom and
// colours.
const char kViewScript[] = R"js(
"use strict";
(function () {
var box = document.getElementById("view-box"), says = document.getElementById("view-says");
var store = document.getElementById("view-data"), tools = document.getElementById("view-tools");
var legend = document.getElementById("view-errors"), openBox = document.getElementById("view-open");
if (!box || !store) return;
var of = box.dataset, canvas = null, gl = null, mesh = null, programs = null, colours = "shaded", waiting = false;
var view = {az: -45, el: 35.26438968, zoom: 1, x: 0, y: 0, fit: 1};
var SIDES = {"iso": [-45, 35.26438968], "+x": [0, 0], "-x": [180, 0], "+y": [90, 0], "-y": [-90, 0], "+z": [-90, 90], "-z": [-90, -90]};
var HELP = "Drag turns, with shift or two fingers moves; wheel (after a click), pinch, + and - zoom; arrow keys turn, 0 goes back; a click tells the place.";

function say(text) { says.textContent = text; says.hidden = false; }
function numbers(text) { return text.split(" ").map(Number); }
function shades(text) {
  var list = [];
  for (var at = 0; at < text.length; at += 2) list.push(parseInt(text.substr(at, 2), 16));
  return list;
}

function unpack() {
  var text = atob(store.textContent), at = 0, n, k;
  store.textContent = "";
  function byte() { return text.charCodeAt(at++); }
  function difference() {
    var value = 0, place = 1, part;
    do { part = byte(); value += (part & 127) * place; place *= 128; } while (part > 127);
    return value % 2 ? -(value + 1) / 2 : value / 2;
  }
  var m = {size: numbers(of.size), low: numbers(of.low)};
  m.places = new Uint16Array(3 * of.vertices);
  for (n = 0; n < m.places.length; ++n) { k = byte(); m.places[n] = k + 256 * byte(); }
  m.corners = new Uint32Array(3 * of.triangles);
  for (n = 0, k = 0; n < m.corners.length; n += 3) {
    k = m.corners[n] = k + difference();
    m.corners[n + 1] = m.corners[n] + difference();
    m.corners[n + 2] = m.corners[n + 1] + difference();
  }
  m.patch = new Uint8Array(+of.patches);
  for (n = 0; n < m.patch.length; ++n) m.patch[n] = byte();
  m.error = new Uint8Array(+of.errors);
  for (n = 0; n < m.error.length; ++n) m.error[n] = byte();
  m.open = new Uint32Array(2 * of.open);
  for (n = 0, k = 0; n < m.open.length; n += 2) { k = m.open[n] = k + difference(); m.open[n + 1] = k + difference(); }
  if (at !== text.length) throw new Error("the numbers of the view are damaged");
  m.radius = Math.sqrt(m.size[0] * m.size[0] + m.size[1] * m.size[1] + m.size[2] * m.size[2]) / 2;
  m.shades = shades(of.shades);
  m.patchColours = shades(of.patchColours);
  m.errorColours = shades(of.errorColours);
  return m;
}

function place(v, axis) { return mesh.places[3 * v + axis] / 65535 * mesh.size[axis]; }

function program(vertex, fragment) {
  var p = gl.createProgram();
  [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]].forEach(function (part) {
    var shader = gl.createShader(part[0]);
    gl.shaderSource(shader, "precision highp float;" + part[1]);
    gl.compileShader(shader);
    gl.attachShader(p, shader);
  });
  gl.linkProgram(p);
  if (!gl.getProgramParameter(p, gl.LINK_STATUS)) throw new Error("the shaders of the view do not work here");
  return p;
}

function buffer(data) {
  var b = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, b);
  gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
  return b;
}

var SPOT = "uniform vec3 size;uniform mat3 turn;uniform vec2 scale,shift;uniform float depth;" +
  "vec3 spot(vec3 p){vec3 q=turn*((p-.5)*size);return vec3(q.xy*scale+shift,-q.z*depth);}";

function upload() {
  var triangles = +of.triangles, n, k, a;
  programs = {
    face: program(SPOT + "attribute vec3 p,n,c;varying vec3 vn,vc;void main(){gl_Position=vec4(spot(p),1.);vn=turn*n;vc=c;}",
      "uniform vec3 inside;uniform float number;varying vec3 vn,vc;void main(){vec3 n=normalize(vn);bool front=n.z>=0.;if(!front)n=-n;" +
      "float light=clamp(.34+.72*dot(n,vec3(-.32,.42,.849)),.3,1.06);vec3 c=vc;" +
      "if(number>.5){light=.62+.38*light;if(!front)c=mix(c,vec3(.5),.5);}else if(!front)c=inside;gl_FragColor=vec4(c*light,1.);}"),
    edge: program(SPOT + "attribute vec3 p,q;attribute vec2 s;uniform vec2 pixel;void main(){vec3 a=spot(p),b=spot(q);" +
      "vec2 d=(b.xy-a.xy)/pixel;float l=length(d);d=l>0.?d/l:vec2(1.,0.);vec3 m=mix(a,b,s.x);" +
      "m.xy+=(vec2(-d.y,d.x)*s.y+d*(s.x-.5))*pixel;gl_Position=vec4(m.xy,m.z-.004,1.);}",
      "uniform vec3 open;void main(){gl_FragColor=vec4(open,1.);}")
  };
  var places = new Uint16Array(12 * triangles), normals = new Int8Array(12 * triangles);
  for (n = 0; n < triangles; ++n) {
    var c = [[], [], []];
    for (k = 0; k < 3; ++k) for (a = 0; a < 3; ++a) {
      var v = mesh.corners[3 * n + k];
      places[12 * n + 4 * k + a] = mesh.places[3 * v + a];
      c[k].push(place(v, a));
    }
    var u = [c[1][0] - c[0][0], c[1][1] - c[0][1], c[1][2] - c[0][2]], w = [c[2][0] - c[0][0], c[2][1] - c[0][1], c[2][2] - c[0][2]];
    var normal = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]];
    var length = Math.sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]) || 1;
    for (k = 0; k < 3; ++k) for (a = 0; a < 3; ++a) normals[12 * n + 4 * k + a] = Math.round(normal[a] / length * 127);
  }
  programs.places = buffer(places);
  programs.normals = buffer(normals);
  programs.paint = gl.createBuffer();
  var edges = +of.open, ends = new Uint16Array(48 * edges), sides = new Int8Array(24 * edges);
  var CORNERS = [[0, -1], [1, -1], [1, 1], [0, -1], [1, 1], [0, 1]];
  for (n = 0; n < edges; ++n) for (k = 0; k < 6; ++k) {
    for (a = 0; a < 3; ++a) {
      ends[48 * n + 8 * k + a] = mesh.places[3 * mesh.open[2 * n] + a];
      ends[48 * n + 8 * k + 4 + a] = mesh.places[3 * mesh.open[2 * n + 1] + a];
    }
    sides[24 * n + 4 * k] = CORNERS[k][0];
    sides[24 * n + 4 * k + 1] = CORNERS[k][1];
  }
  programs.ends = buffer(ends);
  programs.sides = buffer(sides);
  paint();
}

function paint() {
  var triangles = +of.triangles, data = new Uint8Array(12 * triangles), n, k, a;
  for (n = 0; n < triangles; ++n) for (k = 0; k < 3; ++k) for (a = 0; a < 3; ++a)
    data[12 * n + 4 * k + a] = colours === "patches" ? mesh.patchColours[3 * mesh.patch[n] + a] :
      colours === "error" ? mesh.errorColours[3 * mesh.error[mesh.corners[3 * n + k]] + a] : mesh.shades[a];
  gl.bindBuffer(gl.ARRAY_BUFFER, programs.paint);
  gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
}

function attribute(p, name, data, count, type, normal, stride, offset) {
  var at = gl.getAttribLocation(p, name);
  gl.bindBuffer(gl.ARRAY_BUFFER, data);
  gl.enableVertexAttribArray(at);
  gl.vertexAttribPointer(at, count, type, normal, stride, offset);
  return at;
}

/* Right, up and towards the eye. */
function axes() {
  var a = view.az * Math.PI / 180, e = view.el * Math.PI / 180;
  var ca = Math.cos(a), sa = Math.sin(a), ce = Math.cos(e), se = Math.sin(e);
  return [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]];
}

/* The whole mesh as large and as much in the middle as it goes from here; `fit` in mm per half height. */
function fitted() {
  var at = axes(), low = [1e300, 1e300], high = [-1e300, -1e300];
  for (var n = 0; n < of.vertices; ++n) {
    var d = [place(n, 0) - mesh.size[0] / 2, place(n, 1) - mesh.size[1] / 2, place(n, 2) - mesh.size[2] / 2];
    for (var a = 0; a < 2; ++a) {
      var c = at[a][0] * d[0] + at[a][1] * d[1] + at[a][2] * d[2];
      low[a] = Math.min(low[a], c);
      high[a] = Math.max(high[a], c);
    }
  }
  if (low[0] > high[0]) low = high = [0, 0];
  var shape = canvas.clientWidth / Math.max(1, canvas.clientHeight);
  view.fit = .53 * Math.max(high[1] - low[1], (high[0] - low[0]) / shape, 1e-9);
  view.x = -(low[0] + high[0]) / 2;
  view.y = -(low[1] + high[1]) / 2;
}

function scaleNow() {
  var high = view.zoom / view.fit;
  return [high * canvas.clientHeight / Math.max(1, canvas.clientWidth), high];
}

function draw() {
  waiting = false;
  if (!gl || !programs || gl.isContextLost()) return;
  var dots = window.devicePixelRatio || 1;
  var w = Math.max(1, Math.round(canvas.clientWidth * dots)), h = Math.max(1, Math.round(canvas.clientHeight * dots));
  if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
  var at = axes(), turn = [], scale = scaleNow();
  for (var a = 0; a < 3; ++a) turn.push(at[0][a], at[1][a], at[2][a]);
  gl.viewport(0, 0, w, h);
  gl.clearColor(1, 1, 1, 1);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.enable(gl.DEPTH_TEST);
  function use(p) {
    gl.useProgram(p);
    gl.uniform3fv(gl.getUniformLocation(p, "size"), mesh.size);
    gl.uniformMatrix3fv(gl.getUniformLocation(p, "turn"), false, turn);
    gl.uniform2f(gl.getUniformLocation(p, "scale"), scale[0], scale[1]);
    gl.uniform2f(gl.getUniformLocation(p, "shift"), view.x * scale[0], view.y * scale[1]);
    gl.uniform1f(gl.getUniformLocation(p, "depth"), .98 / mesh.radius);
  }
  function shade(first) { return [mesh.shades[first] / 255, mesh.shades[first + 1] / 255, mesh.shades[first + 2] / 255]; }
  var p = programs.face;
  use(p);
  gl.uniform3fv(gl.getUniformLocation(p, "inside"), shade(3));
  gl.uniform1f(gl.getUniformLocation(p, "number"), colours === "shaded" ? 0 : 1);
  var on = [attribute(p, "p", programs.places, 3, gl.UNSIGNED_SHORT, true, 8, 0),
    attribute(p, "n", programs.normals, 3, gl.BYTE, true, 4, 0), attribute(p, "c", programs.paint, 3, gl.UNSIGNED_BYTE, true, 4, 0)];
  gl.drawArrays(gl.TRIANGLES, 0, 3 * of.triangles);
  on.forEach(function (n) { gl.disableVertexAttribArray(n); });
  if (+of.open === 0 || (openBox && !openBox.checked)) return;
  p = programs.edge;
  use(p);
  /* Red would be a number in the picture of errors. */
  gl.uniform3fv(gl.getUniformLocation(p, "open"), colours === "error" ? [.13, .15, .17] : shade(6));
  gl.uniform2f(gl.getUniformLocation(p, "pixel"), 2.4 * dots / w, 2.4 * dots / h);
  on = [attribute(p, "p", programs.ends, 3, gl.UNSIGNED_SHORT, true, 16, 0),
    attribute(p, "q", programs.ends, 3, gl.UNSIGNED_SHORT, true, 16, 8), attribute(p, "s", programs.sides, 2, gl.BYTE, false, 4, 0)];
  gl.drawArrays(gl.TRIANGLES, 0, 6 * of.open);
  on.forEach(function (n) { gl.disableVertexAttribArray(n); });
}

function again() {
  if (!waiting) { waiting = true; window.requestAnimationFrame(draw); }
}

function turn(az, el) {
  view.az = (view.az + az) % 360;
  view.el = Math.max(-90, Math.min(90, view.el + el));
  again();
}

/* Pixels to the right and up. */
function move(x, y) {
  var mm = 2 / (scaleNow()[1] * Math.max(1, canvas.clientHeight));
  view.x += x * mm;
  view.y += y * mm;
  again();
}

/* What lies under a spot (pixels from the middle, up) stays there. */
function zoom(factor, x, y) {
  var before = 2 / (scaleNow()[1] * Math.max(1, canvas.clientHeight));
  factor = Math.max(.2, Math.min(400, view.zoom * factor)) / view.zoom;
  view.zoom *= factor;
  view.x += x * before * (1 / factor - 1);
  view.y += y * before * (1 / factor - 1);
  again();
}

function from(az, el) {
  view.az = az;
  view.el = el;
  view.zoom = 1;
  fitted();
  again();
}

function choose(name) {
  var input = tools.querySelector("input[value=\"" + name + "\"]");
  if (!input) return;
  input.checked = true;
  colours = name;
  if (legend) legend.hidden = name !== "error";
  if (programs) paint();
  again();
}

/* The foremost triangle under a spot, by its own corners. */
function tell(x, y) {
  var at = axes(), mm = 2 / (scaleNow()[1] * Math.max(1, canvas.clientHeight)), px = x * mm - view.x, py = y * mm - view.y;
  var seen = new Float64Array(3 * of.vertices), n, k, a, best = null;
  for (n = 0; n < of.vertices; ++n) for (a = 0; a < 3; ++a) {
    var d = place(n, a) - mesh.size[a] / 2;
    for (k = 0; k < 3; ++k) seen[3 * n + k] += at[k][a] * d;
  }
  for (n = 0; n < mesh.corners.length; n += 3) {
    var i = 3 * mesh.corners[n], j = 3 * mesh.corners[n + 1], l = 3 * mesh.corners[n + 2];
    var u = (seen[j] - px) * (seen[l + 1] - py) - (seen[l] - px) * (seen[j + 1] - py);
    var v = (seen[l] - px) * (seen[i + 1] - py) - (seen[i] - px) * (seen[l + 1] - py);
    var w = (seen[i] - px) * (seen[j + 1] - py) - (seen[j] - px) * (seen[i + 1] - py);
    if (!((u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0)) || u + v + w === 0) continue;
    var sum = u + v + w, depth = (u * seen[i + 2] + v * seen[j + 2] + w * seen[l + 2]) / sum;
    if (!best || depth > best.depth) best = {depth: depth, n: n, share: [u / sum, v / sum, w / sum]};
  }
  if (!best) { say(HELP); return; }
  var where = [0, 0, 0], near = 0;
  for (k = 0; k < 3; ++k) {
    for (a = 0; a < 3; ++a) where[a] += best.share[k] * (mesh.low[a] + place(mesh.corners[best.n + k], a));
    if (best.share[k] > best.share[near]) near = k;
  }
  var text = "At (" + where.map(function (c) { return c.toFixed(2); }).join(", ") + ") mm";
  if (mesh.error.length) {
    var code = mesh.error[mesh.corners[best.n + near]], range = +of.range;
    text += code === 0 ? "; no fit error is known here" : code === 1 ? "; fit error below -" + range + " mm" :
      code === 255 ? "; fit error above " + range + " mm" :
      "; fit error of the nearest vertex\u2019s bin about " + ((code - 128) / 126 * range).toPrecision(2) + " mm";
  }
  say(text + ".");
}

function listen() {
  var held = {}, far = 0, moved = 0, ids = function () { return Object.keys(held); };
  function spot(e) {
    var r = canvas.getBoundingClientRect();
    return [e.clientX - r.left - r.width / 2, r.height / 2 - (e.clientY - r.top)];
  }
  canvas.addEventListener("pointerdown", function (e) {
    try { canvas.setPointerCapture(e.pointerId); } catch (gone) { return; }
    held[e.pointerId] = [e.clientX, e.clientY];
    moved = ids().length > 1 ? 99 : 0;
    far = 0;
  });
  canvas.addEventListener("pointermove", function (e) {
    var old = held[e.pointerId];
    if (!old) return;
    var dx = e.clientX - old[0], dy = e.clientY - old[1], many = ids();
    held[e.pointerId] = [e.clientX, e.clientY];
    moved += Math.abs(dx) + Math.abs(dy);
    if (many.length === 1) {
      if (e.shiftKey || e.buttons & 6) move(dx, -dy); else turn(-.4 * dx, .4 * dy);
      return;
    }
    var a = held[many[0]], b = held[many[1]], apart = Math.max(10, Math.sqrt(Math.pow(a[0] - b[0], 2) + Math.pow(a[1] - b[1], 2)));
    move(dx / 2, -dy / 2);
    if (far > 0) zoom(apart / far, spot({clientX: (a[0] + b[0]) / 2, clientY: 0})[0], spot({clientX: 0, clientY: (a[1] + b[1]) / 2})[1]);
    far = apart;
  });
  function release(e) {
    var was = held[e.pointerId];
    delete held[e.pointerId];
    far = 0;
    if (was && e.type === "pointerup" && moved < 4 && e.button === 0) { var s = spot(e); tell(s[0], s[1]); }
  }
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("contextmenu", function (e) { e.preventDefault(); });
  canvas.addEventListener("wheel", function (e) {
    /* The page scrolls over a view that nobody has touched. */
    if (document.activeElement !== canvas && !e.ctrlKey) return;
    e.preventDefault();
    var s = spot(e);
    zoom(Math.pow(1.0015, -e.deltaY * (e.deltaMode === 1 ? 33 : 1)), s[0], s[1]);
  }, {passive: false});
  canvas.addEventListener("keydown", function (e) {
    if (e.ctrlKey || e.altKey || e.metaKey) return;
    var by = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[e.key];
    if (by) { if (e.shiftKey) move(24 * by[0], 24 * by[1]); else turn(6 * by[0], 6 * by[1]); }
    else if (e.key === "+" || e.key === "=") zoom(1.2, 0, 0);
    else if (e.key === "-") zoom(1 / 1.2, 0, 0);
    else if (e.key === "0" || e.key === "Home") from(-45, 35.26438968);
    else if (e.key === "1" || e.key === "2" || e.key === "3") choose(["shaded", "patches", "error"][e.key - 1]);
    else return;
    e.preventDefault();
  });
  canvas.addEventListener("webglcontextlost", function (e) { e.preventDefault(); programs = null; box.classList.remove("live"); canvas.hidden = true; });
  canvas.addEventListener("webglcontextrestored", function () { canvas.hidden = false; box.classList.add("live"); upload(); again(); });
  tools.addEventListener("change", function (e) { if (e.target.name === "view-colours") choose(e.target.value); else again(); });
  tools.addEventListener("click", function (e) { if (SIDES[e.target.value]) from(SIDES[e.target.value][0], SIDES[e.target.value][1]); });
  if (window.ResizeObserver) new ResizeObserver(again).observe(canvas); else window.addEventListener("resize", again);
}

function fromAddress() {
  var told = /^#view=(-?[\d.]+),(-?[\d.]+)(?:,([\d.]+))?(?:,(\w+))?$/.exec(location.hash);
  if (!told || !gl) return !!told;
  from(+told[1] || 0, Math.max(-90, Math.min(90, +told[2] || 0)));
  if (+told[3] > 0) view.zoom = Math.min(400, +told[3]);
  if (told[4]) choose(told[4]);
  return true;
}

function start() {
  if (canvas) return;
  canvas = document.createElement("canvas");
  try {
    var wanted = {antialias: true, alpha: false, preserveDrawingBuffer: true};
    gl = canvas.getContext("webgl", wanted) || canvas.getContext("experimental-webgl", wanted);
    if (!gl) throw new Error("this browser offers no WebGL");
    mesh = unpack();
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", "the mesh, to be turned by mouse, touch or arrow keys");
    box.insertBefore(canvas, says);
    box.classList.add("live");
    upload();
    tools.hidden = false;
    say(HELP);
    from(view.az, view.el);
    listen();
    fromAddress();
  } catch (why) {
    gl = null;
    if (canvas.parentNode) box.removeChild(canvas);
    box.classList.remove("live");
    tools.hidden = true;
    say("No 3-D view: " + why.message + ".");
  }
}

window.addEventListener("hashchange", function () { if (fromAddress()) { start(); box.scrollIntoView(); } });
if (fromAddress()) { box.scrollIntoView(); start(); }
else if (window.IntersectionObserver) {
  var near = new IntersectionObserver(function (seen) {
    if (seen.some(function (one) { return one.isIntersecting; })) { near.disconnect(); window.setTimeout(start, 0); }
  }, {rootMargin: "300px"});
  near.observe(box);
} else window.addEventListener("load", start);
})();
)js";

}  // namespace scanmill::report
