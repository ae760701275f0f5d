"""How the pages of tools in Python look, light and dark."""

STYLE = """
:root{color-scheme:light;--bg:#f6f7f9;--card:#fff;--line:#e2e5ea;--text:#1b212b;--soft:#657083;
--now:#2563c9;--then:#9aa3b1;--good:#15803d;--bad:#c02626}
@media(prefers-color-scheme:dark){:root{color-scheme:dark;--bg:#0f1217;--card:#171b22;
--line:#2a303a;--text:#e6e9ef;--soft:#93a0b4;--now:#6ea0ff;--then:#7b8698;--good:#6ddb93;
--bad:#ff8585}}
body{margin:0;background:var(--bg);color:var(--text);font:14px/1.5 system-ui,sans-serif}
main{max-width:1280px;margin:0 auto;padding:24px 20px 60px}
h1{font-size:22px;margin:0 0 4px}h2{font-size:16px;margin:30px 0 10px}.sub{color:var(--soft)}
.card{background:var(--card);border:1px solid var(--line);border-radius:12px;padding:12px;
margin-bottom:12px;overflow-x:auto}
.grid{display:grid;grid-template-columns:repeat(auto-fit,minmax(560px,1fr));gap:12px}
table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:13px;width:100%}
th,td{padding:2px 8px;text-align:right;border-bottom:1px solid var(--line);white-space:nowrap}
th:first-child,td:first-child{text-align:left}th{color:var(--soft);font-weight:500}
a{color:inherit}.better{color:var(--good)}.worse{color:var(--bad)}
svg{display:block;width:100%}svg text{font-size:11px;fill:var(--text)}svg .soft{fill:var(--soft)}
.now{fill:var(--now)}.then{fill:var(--then)}.range{stroke:var(--text);stroke-width:1.2}
.rule{stroke:var(--line)}
"""
