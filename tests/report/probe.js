const luminance = (c) => {
  const [r, g, b] = c.map((v) => v / 255).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
};
const colour = (text) => text.match(/[\d.]+/g).map(Number);
const ground = (element) => {
  for (let at = element; at; at = at.parentElement) {
    const c = colour(getComputedStyle(at).backgroundColor);
    if (c.length < 4 || c[3] > 0) return c;
  }
  return [255, 255, 255];
};
document.querySelectorAll("details").forEach((d) => { d.open = true; });
const found = { overflow: [], cut: [], contrast: [] };
const width = document.documentElement.clientWidth;
if (document.documentElement.scrollWidth > width)
  for (const e of document.body.querySelectorAll("*"))
    if (e.getBoundingClientRect().right > width + 1 && !e.closest(".scroll, .frame"))
      found.overflow.push(e.tagName + ": " + e.textContent.trim().slice(0, 60));
for (const box of document.querySelectorAll(".scroll, .frame, pre, .verdict"))
  if (box.scrollWidth > box.clientWidth + 1) found.cut.push(box.tagName + " " + box.id + " " + box.scrollWidth + " > " + box.clientWidth);
for (const e of document.body.querySelectorAll("*")) {
  const own = [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim());
  if (!own || !e.getClientRects().length || ["SCRIPT", "STYLE"].includes(e.tagName)) continue;
  const a = luminance(colour(getComputedStyle(e).color)), b = luminance(ground(e));
  const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  if (ratio < 4.5) found.contrast.push(ratio.toFixed(2) + " " + e.tagName + "." + e.className + ": " + e.textContent.trim().slice(0, 40));
}
found.text = document.querySelectorAll("td").length;
parent.postMessage(JSON.stringify(found), "*");
