// The theme's own, which Debian leaves out: its style of tables.
document.addEventListener("DOMContentLoaded", () => {
  for (const table of document.querySelectorAll("table")) table.classList.add("docutils");
});
