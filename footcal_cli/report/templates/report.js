"use strict";
// Tables sort on a click on a column's head; details open before printing and when linked to.
const key = (row, column) => {
  const text = row.cells[column] ? row.cells[column].textContent.trim() : "";
  const number = text.replace(/−/g, "-").replace(/,/g, "").match(/^[^\d-]{0,2}(-?\d+\.?\d*)/);
  const raised = text.match(/× 10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)/);
  const power = raised ? [...raised[1]].map((c) => "0123456789-"["⁰¹²³⁴⁵⁶⁷⁸⁹⁻".indexOf(c)]).join("") : "0";
  return { text, number: number ? parseFloat(`${number[1]}e${power}`) : NaN };
};
for (const table of document.querySelectorAll("table.sortable")) {
  table.querySelectorAll("thead th").forEach((head, column) => {
    const button = document.createElement("button");
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      table.querySelectorAll("th[aria-sort]").forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const unfold = table.querySelector("tr.fold input");
      if (unfold) unfold.checked = true;
      for (const body of table.querySelectorAll("tbody.rows, tbody.folded")) {
        const rows = [...body.rows].map((row) => [row, key(row, column)]);
        rows.sort(([, a], [, b]) => {
          if (isNaN(a.number) !== isNaN(b.number)) return isNaN(a.number) ? 1 : -1;
          const order = isNaN(a.number) ? a.text.localeCompare(b.text) : a.number - b.number;
          return down ? -order : order;
        });
        body.append(...rows.map(([row]) => row));
      }
    });
  });
}
const open = (target) => {
  for (let at = target; at; at = at.parentElement) if (at.tagName === "DETAILS") at.open = true;
};
addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((d) => { d.open = true; }));
addEventListener("hashchange", () => open(document.getElementById(location.hash.slice(1))));
open(document.getElementById(location.hash.slice(1)));
// Figures with curves: a button swaps the picture for panels to zoom into and read values off.
const widest = (_, labels) => 26 + 7 * Math.max(2, ...(labels || []).map((label) => label.length));
const panelOf = (panel, width, sync, last) => {
  const tables = panel.curves.map((curve) => [curve.x, curve.y]);
  const series = panel.curves.map((curve) => ({
    label: curve.label, stroke: curve.colour, width: curve.points ? 0 : 1.2, spanGaps: false,
    points: { show: curve.points, size: 4 },
    value: (_, v) => (v == null ? "–" : String(+v.toPrecision(5)).replace("-", "−")),
  }));
  const font = "12px system-ui, sans-serif";
  const axis = { font, labelFont: font, grid: { stroke: "#e3e6ea" }, ticks: { stroke: "#e3e6ea" } };
  return {
    data: uPlot.join(tables, tables.map(() => [null, 2])),
    options: {
      title: panel.title, width, height: last ? 210 : 180,
      cursor: { sync: { key: sync }, drag: { x: true, y: false } },
      scales: { x: { time: false } },
      axes: [
        last ? { ...axis, label: panel.x, labelSize: 18 } : axis,
        { ...axis, label: panel.y, labelSize: 18, labelGap: 2, size: widest },
      ],
      series: [{ label: panel.x || "x" }, ...series],
    },
  };
};
document.querySelectorAll("script.curves").forEach((source, number) => {
  const figure = source.closest("figure");
  const frame = figure.querySelector(".frame");
  const button = document.createElement("button");
  const panels = document.createElement("div");
  let drawn = [];
  panels.className = "panels";
  panels.hidden = true;
  frame.after(panels);
  button.className = "zoom";
  button.textContent = "Zoom and read values";
  button.addEventListener("click", () => {
    const show = panels.hidden;
    panels.hidden = !show;
    frame.hidden = show;
    button.textContent = show ? "Back to the picture" : "Zoom and read values";
    if (show && !drawn.length) {
      const hint = document.createElement("p");
      hint.textContent = "Drag across to zoom in, double-click to see all; click a name to hide its curve.";
      panels.append(hint);
      drawn = JSON.parse(source.textContent).map((panel, i, every) => {
        const last = i + 1 === every.length || every[i + 1].x !== panel.x;
        const { options, data } = panelOf(panel, panels.clientWidth, `figure-${number}`, last);
        return new uPlot(options, data, panels);
      });
    }
  });
  addEventListener("resize", () => drawn.forEach((plot) => plot.setSize({ width: panels.clientWidth, height: plot.height })));
  addEventListener("beforeprint", () => { if (!panels.hidden) button.click(); });
  figure.querySelector("figcaption").append(" ", button);
});
