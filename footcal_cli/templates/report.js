"use strict";
// Tables sort on a click on a column's head; details open before printing and when linked to.
const key = (row, column) => {
  const text = row.cells[column] ? row.cells[column].textContent.trim() : "";
  const number = text.replace(/−/g, "-").replace(/,/g, "").match(/^[^\d-]{0,2}(-?\d+\.?\d*(e[+-]?\d+)?)/);
  return { text, number: number ? parseFloat(number[1]) : NaN };
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
