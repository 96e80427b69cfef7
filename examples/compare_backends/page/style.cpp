#include "touchstone/examples/compare_backends/page/sections.hpp"

namespace touchstone::comparison {

std::string page_style() {
  return R"(:root{color-scheme:light dark;--ink:#1b1f24;--soft:#5b6470;--line:#d5dae0;--paper:#fff;--tint:#f1f4f8;--bad:#a5370a}
@media (prefers-color-scheme:dark){:root{--ink:#e8eaed;--soft:#a3abb5;--line:#3a414a;--paper:#14171a;--tint:#1d2126;--bad:#ff9a61}}
@media print{:root{--ink:#000;--soft:#444;--line:#ccc;--paper:#fff;--tint:#fff}}
body{margin:0 auto;padding:28px 24px 60px;max-width:1240px;background:var(--paper);color:var(--ink);
font:15px/1.5 system-ui,sans-serif}
h1{font-size:26px;margin:0 0 4px}h2{font-size:19px;margin:38px 0 6px;border-top:1px solid var(--line);padding-top:18px}
h3{font-size:15px;margin:22px 0 4px}p{margin:6px 0;max-width:78ch}.soft{color:var(--soft)}
.verdict{background:var(--tint);border-left:4px solid #0072b2;padding:12px 16px;margin:16px 0}
.verdict strong{font-size:17px}.plots{display:grid;grid-template-columns:repeat(auto-fill,minmax(500px,1fr));gap:14px 20px}
.plots svg.plot:not(.key){width:100%;height:auto}.key{vertical-align:-3px;margin-right:6px}
.legend span{display:inline-block;margin:0 18px 4px 0}.scroll{overflow-x:auto}
table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:13px;margin:6px 0 10px}
td,th{padding:3px 9px;text-align:right;border-bottom:1px solid var(--line);white-space:nowrap;font-weight:400}
thead th{color:var(--soft)}th:first-child{text-align:left}code{background:var(--tint);padding:1px 4px;font-size:13px}
.ranks{display:grid;grid-template-columns:repeat(auto-fit,minmax(350px,1fr));gap:0 28px;align-items:start}.ranks table{width:100%}
.wrong{color:var(--bad);white-space:normal}.ranks .wrong{font-size:12px;line-height:1.35}.n{white-space:nowrap}.right{color:var(--soft)}
.matrix td,.matrix thead th{padding:3px 6px;font-size:11.5px;line-height:1.3;text-align:center;vertical-align:middle}
.errors td{white-space:normal;min-width:62px}.matrix{width:100%}.matrix td{border-left:1px solid var(--line)}.matrix thead th:first-child{text-align:left}.w2{background:color-mix(in srgb,var(--bad) 9%,transparent)}.w3{background:color-mix(in srgb,var(--bad) 20%,transparent)}
.gap{color:var(--bad)}dl{display:grid;grid-template-columns:max-content 1fr;gap:3px 18px;margin:8px 0}dt{font-weight:600}dd{margin:0}
.source{font-size:12px;color:var(--soft);max-width:none}.source code{font-size:12px}small{font-size:10.5px;color:var(--soft)}
.out,.out th{color:var(--soft)}.controls{display:flex;flex-wrap:wrap;gap:8px 22px;align-items:center;margin:8px 0}.controls[hidden]{display:none}
.controls input[type=range]{width:min(420px,60vw);vertical-align:middle}.controls input,.controls select{font:inherit;color:inherit;background:var(--paper);border:1px solid var(--line);padding:2px 6px}
.ranked td:nth-child(5){text-align:left}.verdict h2{border:0;margin:0;padding:0}.one-verdict{margin:8px 0}.verdict p{max-width:110ch}
.plots.three{grid-template-columns:repeat(auto-fill,minmax(370px,1fr))}.plots.small{grid-template-columns:repeat(auto-fill,minmax(250px,1fr))}
.gallery{display:grid;grid-template-columns:repeat(auto-fill,minmax(380px,1fr));gap:18px 24px}figure{margin:0}figure>svg.plot{width:100%;height:auto;max-width:480px}
figcaption{font-size:12.5px}figcaption td,figcaption th{font-size:10.5px;padding:1px 4px}.exact-row{font-weight:600}.exact-row th,.exact-row td{font-weight:600}
summary{cursor:pointer}summary h3{display:inline}.matrix ul{text-align:left;margin:2px 0;padding-left:14px}.matrix details p{font-size:10.5px;text-align:left;white-space:normal}
.matrix details[open]{min-width:190px}.schema td{text-align:left;white-space:normal}svg.plot{max-width:100%}body>svg.plot{display:block;max-width:min(760px,100%)}.plots>.gap{align-self:center}
@page{size:A4 landscape;margin:11mm}
@media print{.plots>*,.ranks>*,tr{break-inside:avoid}.scroll{overflow:visible}
body{padding:0;max-width:none;font-size:11px}td,th{padding:2px 4px;font-size:8.5px;white-space:normal}h2,h3{break-after:avoid}.plots,.plots.three,.scenes{display:grid;grid-template-columns:1fr 1fr 1fr;gap:6px 12px}.controls,.screen{display:none!important}.scenes{grid-template-columns:1fr 1fr;gap:6px 24px}.scenes svg.plot{width:100%}.plots.small{grid-template-columns:repeat(4,1fr)}.gallery{grid-template-columns:1fr 1fr 1fr}figure,.verdict section,.scenes section{break-inside:avoid}figure>svg.plot{max-height:42mm}figcaption td,figcaption th{font-size:7px;padding:0 3px;white-space:nowrap}figcaption{font-size:9px}figcaption code{font-size:8px}.source{font-size:8px}h2{margin-top:14px;padding-top:8px}h3{margin-top:8px}}
@media screen{.print{display:none}}
)";
}

}  // namespace touchstone::comparison
