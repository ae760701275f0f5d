#include "tools/report/page.h"

namespace pirvs::tools {
namespace {

constexpr char kStyle[] = R"css(
:root{color-scheme:light;--bg:#f6f7f9;--card:#fff;--line:#e2e5ea;--grid:#eceef2;--text:#1b212b;
--soft:#657083;--accent:#2563c9;--truth:#9aa3b1;--s1:#2563c9;--s2:#e08a1e;--s3:#1a9a78;
--s4:#a2479e;
--s5:#6b7280;--x:#d0454c;--y:#1f9d61;--z:#2f6fd6;--good:#15803d;--warn:#b45309;--bad:#c02626;
--good-bg:#e7f6ec;--warn-bg:#fdf1dc;--bad-bg:#fde8e8;--point:#a8b3c4}
@media(prefers-color-scheme:dark){:root:not([data-theme=light]){color-scheme:dark;--bg:#0f1217;
--card:#171b22;--line:#2a303a;--grid:#222832;--text:#e6e9ef;--soft:#93a0b4;--accent:#6ea0ff;
--truth:#7b8698;--s1:#6ea0ff;--s2:#f2ad55;--s3:#43c6a0;--s4:#d283ce;--s5:#9aa3b1;--x:#ff7b80;
--y:#55cf93;--z:#74a8ff;--good:#6ddb93;--warn:#f2b35f;--bad:#ff8585;--good-bg:#15301f;
--warn-bg:#37280f;--bad-bg:#3a1818;--point:#5b6880}}
:root[data-theme=dark]{color-scheme:dark;--bg:#0f1217;--card:#171b22;--line:#2a303a;
--grid:#222832;
--text:#e6e9ef;--soft:#93a0b4;--accent:#6ea0ff;--truth:#7b8698;--s1:#6ea0ff;--s2:#f2ad55;
--s3:#43c6a0;--s4:#d283ce;--s5:#9aa3b1;--x:#ff7b80;--y:#55cf93;--z:#74a8ff;--good:#6ddb93;
--warn:#f2b35f;--bad:#ff8585;--good-bg:#15301f;--warn-bg:#37280f;--bad-bg:#3a1818;--point:#5b6880}
*{box-sizing:border-box}
body{margin:0;background:var(--bg);color:var(--text);font:15px/1.5 system-ui,-apple-system,
"Segoe UI",
Roboto,"Helvetica Neue",Arial,sans-serif}
main{max-width:1180px;margin:0 auto;padding:28px 20px 60px}
header{display:flex;align-items:flex-start;gap:16px;flex-wrap:wrap;margin-bottom:20px}
header div{flex:1;min-width:280px}
h1{font-size:24px;line-height:1.25;margin:0 0 4px;letter-spacing:-.01em}
h2{font-size:16px;margin:34px 0 12px}
.sub{color:var(--soft);font-size:13px;overflow-wrap:anywhere}
code{font:12.5px/1.5 ui-monospace,SFMono-Regular,Menlo,Consolas,"DejaVu Sans Mono",monospace}
.pill{padding:4px 12px;border-radius:99px;font-weight:600;font-size:13px;white-space:nowrap}
.good{color:var(--good);background:var(--good-bg)}.warn{color:var(--warn);
background:var(--warn-bg)}
.bad{color:var(--bad);background:var(--bad-bg)}
button{font:inherit;font-size:13px;color:var(--soft);background:var(--card);cursor:pointer;
border:1px solid var(--line);border-radius:99px;padding:3px 12px}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(160px,1fr));gap:12px}
.tile,.card{background:var(--card);border:1px solid var(--line);border-radius:12px}
.tile{padding:14px 16px}
.tile b{display:block;font-size:25px;line-height:1.25;font-weight:650;letter-spacing:-.02em}
.tile b small{font-size:14px;font-weight:500;color:var(--soft);letter-spacing:0;margin-left:3px}
.tile span{color:var(--soft);font-size:12.5px}
.card{padding:14px 14px 8px;margin-bottom:12px}
.two{display:grid;grid-template-columns:repeat(auto-fit,minmax(440px,1fr));gap:12px}
@media(max-width:520px){.two{grid-template-columns:1fr}}
.two .card{margin-bottom:0}.two{margin-bottom:12px}
svg.fig{display:block;width:100%;height:auto;overflow:visible}
svg text{fill:var(--soft);font-size:11.5px;font-variant-numeric:tabular-nums}
svg .title{fill:var(--text);font-size:13.5px;font-weight:600}
.grid{stroke:var(--grid);stroke-width:1}
.line{fill:none;stroke:var(--c);stroke-width:1.6;stroke-linejoin:round;stroke-linecap:round}
.dashed{stroke-dasharray:5 4}.area{fill:var(--c)}.dot{fill:var(--c)}
.s1{--c:var(--s1)}.s2{--c:var(--s2)}.s3{--c:var(--s3)}.s4{--c:var(--s4)}.s5{--c:var(--s5)}
.x{--c:var(--x)}.y{--c:var(--y)}.z{--c:var(--z)}.truth{--c:var(--truth)}.point{--c:var(--point)}
.line.truth{stroke-width:3.2;opacity:.55}.line.path{--c:var(--accent);stroke-width:1.8}
.none{stroke:none}.wait{color:var(--soft);background:var(--grid)}
.start{--c:var(--good)}.end{--c:var(--bad)}
.span{opacity:.55}.span.good{fill:none}.span.warn{fill:var(--warn-bg)}
.span.bad{fill:var(--bad-bg)}
.span.wait{fill:var(--grid)}
.cursor{stroke:var(--soft);stroke-width:1;pointer-events:none}
#tip{position:fixed;pointer-events:none;display:none;background:var(--card);color:var(--text);
border:1px solid var(--line);border-radius:8px;padding:6px 10px;font-size:12px;z-index:9;
box-shadow:0 4px 16px #0003;font-variant-numeric:tabular-nums;white-space:nowrap}
#tip i{display:inline-block;width:9px;height:9px;border-radius:3px;margin-right:6px;
background:var(--c)}
table{border-collapse:collapse;width:100%;font-size:13.5px;font-variant-numeric:tabular-nums}
th{color:var(--soft);font-weight:500;font-size:12.5px}
th,td{text-align:right;padding:6px 10px;border-bottom:1px solid var(--grid)}
th:first-child,td:first-child{text-align:left}tr:last-child td{border-bottom:0}
tr.sum td{font-weight:650}td.paper,th.paper{color:var(--soft)}
.left td,.left th{text-align:left}.scroll{overflow-x:auto}
.columns{columns:3 260px;column-gap:28px;font-size:13px;padding:4px 6px 8px}
.columns div{display:flex;justify-content:space-between;gap:10px;padding:3px 0;break-inside:avoid;
border-bottom:1px solid var(--grid);font-variant-numeric:tabular-nums}
.columns .zero{color:var(--soft);opacity:.7}
#viewer{display:block;width:100%;height:660px;border:1px solid var(--line);border-radius:12px}
.bar{height:8px;border-radius:4px;background:var(--accent);min-width:2px}
)css";

constexpr char kScript[] = R"js(
const root=document.documentElement,tip=document.getElementById('tip');
if(location.hash.length>1)root.dataset.theme=location.hash.slice(1);
document.getElementById('theme').onclick=()=>{const own=root.dataset.theme;
const dark=own?own=='dark':
matchMedia('(prefers-color-scheme:dark)').matches;root.dataset.theme=dark?'light':'dark'};
const figs=[...document.querySelectorAll('svg.fig.time')].map(svg=>{const d=svg.dataset,f={svg};
for(const k of['l','r','t','b','x0','x1','y0','y1'])f[k]=+d[k];
f.lines=[...svg.querySelectorAll('path[data-label]')].map(p=>({p,label:p.dataset.label,
points:null}));
f.cursor=document.createElementNS('http://www.w3.org/2000/svg','line');
f.cursor.setAttribute('class','cursor');f.cursor.setAttribute('y1',f.t);
f.cursor.setAttribute('y2',f.b);
f.cursor.style.display='none';svg.append(f.cursor);return f});
function points(line){if(!line.points)line.points=line.p.getAttribute('d').split(/[ML]/).slice(1)
.map(s=>s.replace('Z','').split(' ').map(Number));return line.points}
function value(f,line,t){const px=f.l+(t-f.x0)/(f.x1-f.x0)*(f.r-f.l);let best=null,dist=12;
let list=points(line);if(f.svg.dataset.stacked)list=list.slice(1,-1);
for(const q of list){const d=Math.abs(q[0]-px);if(d<dist){dist=d;best=q}}
return best?f.y0+(f.b-best[1])/(f.b-f.t)*(f.y1-f.y0):null}
function show(t){for(const f of figs){const x=f.l+(t-f.x0)/(f.x1-f.x0)*(f.r-f.l);
f.cursor.style.display=x>=f.l&&x<=f.r?'':'none';f.cursor.setAttribute('x1',x);
f.cursor.setAttribute('x2',x)}}
for(const f of figs){f.svg.addEventListener('pointermove',
e=>{const box=f.svg.getBoundingClientRect();
const px=(e.clientX-box.left)/box.width*f.svg.viewBox.baseVal.width;
if(px<f.l||px>f.r)return hide();const t=f.x0+(px-f.l)/(f.r-f.l)*(f.x1-f.x0);show(t);
let rows=[],below=0;const lines=f.svg.dataset.stacked?[...f.lines].reverse():f.lines;
for(const line of lines){let v=value(f,line,t);if(v===null||!line.label)continue;
const shown=f.svg.dataset.stacked?v-below:v;below=v;
const c=getComputedStyle(line.p).getPropertyValue('--c');
rows.push(`<div><i style="--c:${c}"></i>${line.label} <b>${Number(shown.toPrecision(3))}
</b></div>`)}
tip.innerHTML=`<div>t = ${t.toFixed(2)} s</div>`+rows.join('');tip.style.display='block';
const w=tip.offsetWidth;
tip.style.left=(e.clientX+16+w>innerWidth?e.clientX-16-w:e.clientX+16)+'px';
tip.style.top=(e.clientY+14)+'px'});f.svg.addEventListener('pointerleave',hide)}
const viewer=document.getElementById('viewer');
if(viewer){addEventListener('message',e=>{
if(e.source==viewer.contentWindow&&e.data.pirvsTime!==undefined)
show(e.data.pirvsTime-viewer.dataset.t0)});
const tell=()=>viewer.contentWindow.postMessage({pirvsTheme:root.dataset.theme},'*');
viewer.onload=()=>{if(root.dataset.theme)tell()};
document.getElementById('theme').addEventListener('click',tell)}
function hide(){tip.style.display='none';for(const f of figs)f.cursor.style.display='none'}
)js";

}  // namespace

std::string html_escape(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '\'':
        out += "&#39;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string html_page(const std::string& title, const std::string& body) {
  return "<!doctype html>\n<html lang=en><head><meta charset=utf-8>"
         "<meta name=viewport content='width=device-width,initial-scale=1'><title>" +
         html_escape(title) + "</title><style>" + kStyle + "</style></head>\n<body><main>\n" +
         body + "</main><div id=tip></div><script>" + kScript + "</script></body></html>\n";
}

}  // namespace pirvs::tools
