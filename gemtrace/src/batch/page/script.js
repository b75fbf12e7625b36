"use strict";
// Cards are sorted by an attribute, numbers as numbers; a second press turns the order around.
const sheet = document.querySelector(".sheet");
const buttons = Array.from(document.querySelectorAll("button[data-key]"));
function compare(a, b) {
  if (a === null || b === null) return (a === null) - (b === null);
  const difference = Number(a) - Number(b);
  return Number.isNaN(difference) ? a.localeCompare(b, "en", { numeric: true }) : difference;
}
function sort(button) {
  const direction = button.dataset.sort === "ascending" ? "descending" : "ascending";
  buttons.forEach(other => { other.dataset.sort = "none"; });
  button.dataset.sort = direction;
  const attribute = "data-" + button.dataset.key;
  const sign = direction === "ascending" ? 1 : -1;
  const value = card => card.getAttribute(attribute);
  const cards = Array.from(sheet.children);
  cards.sort((a, b) => {
    const missing = (value(a) === null) - (value(b) === null);
    return missing || sign * compare(value(a), value(b)) || a.dataset.order - b.dataset.order;
  });
  sheet.append(...cards);
}
buttons.forEach(button => button.addEventListener("click", () => sort(button)));
