// SPDX-License-Identifier: Apache-2.0
#include "support/occt_shapes.hpp"

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESControl_Reader.hxx>
#include <IGESControl_Writer.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_PrinterOStream.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <ctime>
#include <gp_Pln.hxx>
#include <map>
#include <sstream>
#include <utility>
#include <vector>

namespace scanmill::support {
namespace {

void silence() { Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_PrinterOStream)); }

int count(const TopoDS_Shape& shape, TopAbs_ShapeEnum kind) {
  TopTools_IndexedMapOfShape found;
  TopExp::MapShapes(shape, kind, found);
  return found.Extent();
}

TopoDS_Shell shell_of(const Mesh& mesh) {
  std::vector<TopoDS_Vertex> vertices;
  for (const Vec3& p : mesh.positions) vertices.push_back(BRepBuilderAPI_MakeVertex(gp_Pnt(p.x, p.y, p.z)));
  std::map<std::pair<std::uint32_t, std::uint32_t>, TopoDS_Edge> edges;
  BRep_Builder builder;
  TopoDS_Shell shell;
  builder.MakeShell(shell);
  for (const Triangle& t : mesh.triangles) {
    TopoDS_Wire wire;
    builder.MakeWire(wire);
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t a = t[e], b = t[(e + 1) % 3];
      TopoDS_Edge& edge = edges[{std::min(a, b), std::max(a, b)}];
      if (edge.IsNull()) edge = BRepBuilderAPI_MakeEdge(vertices[std::min(a, b)], vertices[std::max(a, b)]);
      builder.Add(wire, a < b ? edge : TopoDS::Edge(edge.Reversed()));
    }
    const Vec3 p = mesh.positions[t[0]];
    const Vec3 n = unit(cross(mesh.positions[t[1]] - p, mesh.positions[t[2]] - p));
    builder.Add(shell,
                BRepBuilderAPI_MakeFace(gp_Pln(gp_Pnt(p.x, p.y, p.z), gp_Dir(n.x, n.y, n.z)), wire, true).Face());
  }
  return shell;
}

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

CadShape read_with_occt(const std::string& path) {
  silence();
  CadShape found;
  IGESControl_Reader reader;
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone) return found;
  found.readable = true;
  found.roots = reader.NbRootsForTransfer();
  reader.TransferRoots();
  const TopoDS_Shape shape = reader.OneShape();
  if (shape.IsNull()) return found;
  found.solids = count(shape, TopAbs_SOLID);
  found.faces = count(shape, TopAbs_FACE);
  found.edges = count(shape, TopAbs_EDGE);
  found.vertices = count(shape, TopAbs_VERTEX);
  for (TopExp_Explorer shells(shape, TopAbs_SHELL); shells.More(); shells.Next()) {
    ++found.shells;
    found.closed_shells += BRep_Tool::IsClosed(shells.Current());
  }
  found.valid = BRepCheck_Analyzer(shape).IsValid();
  for (TopExp_Explorer faces(shape, TopAbs_FACE); faces.More(); faces.Next())
    found.invalid_faces += !BRepCheck_Analyzer(faces.Current()).IsValid();
  GProp_GProps surface, volume, lines;
  BRepGProp::SurfaceProperties(shape, surface);
  found.area = surface.Mass();
  BRepGProp::LinearProperties(shape, lines);
  found.line_length = lines.Mass();
  if (found.solids > 0) BRepGProp::VolumeProperties(shape, volume);
  found.volume = volume.Mass();
  return found;
}

int open_edges_with_occt(const std::string& path, double tolerance_mm) {
  silence();
  IGESControl_Reader reader;
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone) return -1;
  reader.TransferRoots();
  BRepBuilderAPI_Sewing sewing(tolerance_mm);
  sewing.Add(reader.OneShape());
  sewing.Perform();
  return sewing.NbFreeEdges();
}

double write_with_occt(const Mesh& mesh, const std::string& path) {
  silence();
  const TopoDS_Shell shell = shell_of(mesh);
  BRepBuilderAPI_MakeSolid solid(shell);
  IGESControl_Controller::Init();
  const double before = cpu_seconds();
  IGESControl_Writer writer("MM", 1);
  if (!writer.AddShape(solid.Shape())) return -1;
  writer.ComputeModel();
  if (!writer.Write(path.c_str())) return -1;
  return cpu_seconds() - before;
}

}  // namespace scanmill::support
