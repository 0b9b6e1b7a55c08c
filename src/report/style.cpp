// SPDX-License-Identifier: Apache-2.0
#include "report/style.hpp"

namespace scanmill::report {

const char kStyleSheet[] = R"(
:root{--ink:#1f2328;--faint:#59636e;--line:#d5dae0;--wash:#f5f7f9;--pass:#0b5394;--fail:#a4260f;--warn:#7a4b00}
*{box-sizing:border-box}
html{-webkit-text-size-adjust:100%;text-size-adjust:100%}
body{margin:0 auto;padding:1.2rem 1.2rem 3rem;max-width:74rem;background:#fff;color:var(--ink);
font:16px/1.45 system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans","Liberation Sans",sans-serif}
h1{margin:0 0 .2rem;font-size:1.7rem;line-height:1.2;overflow-wrap:anywhere}
h2{margin:2.4rem 0 .6rem;padding-top:.5rem;border-top:2px solid var(--ink);font-size:1.25rem}
h3{margin:1.4rem 0 .4rem;font-size:1.02rem}
p{margin:.4rem 0 .6rem;max-width:60rem}
.sub,.quiet{color:var(--faint)}
.sub,p,li{overflow-wrap:anywhere}
.verdict{display:flex;flex-wrap:wrap;align-items:center;gap:.2rem 1.2rem;margin:1rem 0;padding:.8rem 1.1rem;
border-radius:.4rem;color:#fff;-webkit-print-color-adjust:exact;print-color-adjust:exact}
.verdict strong{font-size:2rem;line-height:1.15;letter-spacing:.02em}
.verdict span{font-size:1.1rem;overflow-wrap:anywhere}
.pass{background:var(--pass)}.fail{background:var(--fail)}.none{background:#4a525b}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(10.5rem,1fr));gap:.6rem;margin:0;padding:0}
.tiles div{padding:.6rem .8rem;border:1px solid var(--line);border-radius:.4rem;background:var(--wash)}
.tiles dt{color:var(--faint);font-size:.86rem}
.tiles dd{margin:0;font-size:1.45rem;font-weight:600;line-height:1.25;font-variant-numeric:tabular-nums}
.tiles dd+dd{font-size:.86rem;font-weight:400;color:var(--faint)}
.tiles .bad{border:2px solid var(--fail)}.tiles .bad dd:first-of-type{color:var(--fail)}
nav{margin:1rem 0 0;font-size:.92rem}
nav a{margin-right:1rem;color:#0b5394;white-space:nowrap}
.notes{margin:.9rem 0 0;padding:0;list-style:none}
.notes li{margin:.3rem 0;padding:.35rem .7rem;border-left:.3rem solid var(--line);background:var(--wash)}
.notes .w{border-color:#d98200;background:#fff6e5}
.notes b{color:var(--warn)}
.pictures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,26rem),1fr));gap:1rem}
figure{margin:0}main>figure{margin:0 0 1.3rem}
figure img,figure svg{display:block;width:100%;height:auto;border:1px solid var(--line);border-radius:.3rem;background:#fff}
figure.chart{max-width:52rem}
.view canvas{display:block;width:100%;height:auto;aspect-ratio:4/3;max-height:76vh;border:1px solid var(--line);
border-radius:.3rem;background:#fff;touch-action:none;cursor:grab}
.view canvas:focus{outline:2px solid var(--pass);outline-offset:1px}
.view figure{max-width:52rem}.view.live figure{display:none}
.view [hidden]{display:none}
.tools{display:flex;flex-wrap:wrap;gap:.35rem .9rem;align-items:center;margin:.4rem 0;font-size:.92rem}
.tools button{min-width:2.3rem;padding:.15rem .4rem;border:1px solid var(--line);border-radius:.3rem;background:var(--wash);
color:var(--ink);font:inherit}
.tools label{white-space:nowrap}
.legend{display:flex;flex-wrap:wrap;gap:.2rem 1rem;align-items:center;font-size:.9rem}
.legend i{display:inline-block;width:1.1rem;height:.8rem;margin:0 .35rem;border:1px solid var(--line);vertical-align:-.05rem;
-webkit-print-color-adjust:exact;print-color-adjust:exact}
.legend .scale{width:min(14rem,40vw)}
figcaption{margin-top:.25rem;color:var(--faint);font-size:.9rem}
.scroll{overflow-x:auto;margin:.5rem 0 1rem}
table{border-collapse:collapse;font-size:.92rem;font-variant-numeric:tabular-nums}
caption{padding:.2rem 0;text-align:left;font-weight:600}
th,td{padding:.24rem .9rem .24rem .5rem;border-bottom:1px solid var(--line);text-align:left;vertical-align:top;
font-weight:400}
thead th{border-bottom:2px solid var(--faint);color:var(--faint);font-size:.86rem;vertical-align:bottom}
tbody th{max-width:24rem;overflow-wrap:anywhere}
tbody tr:hover{background:var(--wash)}
.n{text-align:right;white-space:nowrap}
.p{white-space:nowrap}
.d{font:.78rem/1.5 ui-monospace,"DejaVu Sans Mono","Liberation Mono",monospace;word-break:break-all;min-width:17rem}
tr.bad th,tr.bad td{color:var(--fail);font-weight:600}
tr.changed th,tr.changed td{font-weight:600;background:#eef4fb}
.columns{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,27rem),1fr));gap:0 2rem}
footer{margin-top:2.5rem;padding-top:.6rem;border-top:1px solid var(--line);color:var(--faint);font-size:.86rem}
footer p{overflow-wrap:anywhere}
@media (max-width:40rem){body{padding:.8rem .7rem 2rem}h1{font-size:1.35rem}.verdict strong{font-size:1.6rem}
.tiles{grid-template-columns:1fr 1fr}.tiles dd{font-size:1.2rem}th,td{padding-right:.6rem}.d{min-width:11rem}
tbody th,td:not(.n):not(.p):not(.d){min-width:8.5rem}.tools button{padding:.35rem .5rem}}
@media print{.view canvas,.view .tools,.view .legend,#view-says,.view noscript{display:none}.view.live figure{display:block}
.view figure{max-width:12cm}
@page{margin:14mm}body{max-width:none;padding:0;font-size:10pt}nav{display:none}
h2{margin-top:1.4rem;break-after:avoid}h3,caption{break-after:avoid}figure,tr,.tiles div,.verdict{break-inside:avoid}
.scroll{overflow:visible}.short{break-inside:avoid}.columns{grid-template-columns:1fr 1fr;gap:0 1rem}
table{font-size:8.6pt}.d{font-size:7pt;min-width:0}thead{display:table-header-group}
.pictures{grid-template-columns:1fr 1fr}.tiles{grid-template-columns:repeat(4,1fr)}.tiles dd{font-size:13pt}
th,td{padding:.15rem .5rem .15rem .3rem}tbody th{overflow-wrap:break-word}}
)";

}  // namespace scanmill::report
