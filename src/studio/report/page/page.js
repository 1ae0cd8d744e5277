'use strict';
// Sorts tables after clicks on headings, marks tables that can be scrolled sideways, and enlarges pictures.
for (const th of document.querySelectorAll('tr.columns th')) {
  th.addEventListener('click', () => {
    const table = th.closest('table'), body = table.tBodies[0], down = th.getAttribute('aria-sort') === 'ascending';
    table.querySelectorAll('tr.columns th').forEach(other => other.removeAttribute('aria-sort'));
    th.setAttribute('aria-sort', down ? 'descending' : 'ascending');
    const key = row => {
      const cell = row.cells[th.cellIndex], text = cell?.dataset.v ?? cell?.textContent.replaceAll(',', '');
      return !cell || cell.className === 'why' || text === '' ? null : Number.isNaN(Number(text)) ? cell.textContent : Number(text);
    };
    const order = (a, b) => typeof a === 'number' && typeof b === 'number' ? a - b : String(a).localeCompare(String(b));
    const compare = (a, b) => {
      const x = key(a), y = key(b);
      return x === null || y === null ? (x === null) - (y === null) : down ? -order(x, y) : order(x, y);
    };
    body.append(...[...body.rows].sort(compare));
  });
}
for (const box of document.querySelectorAll('.scroller')) {
  const table = box.querySelector('.table');
  const look = () => {
    const hidden = table.scrollWidth - table.clientWidth;
    box.classList.toggle('more', hidden > 2);
    box.classList.toggle('end', hidden > 2 && table.scrollLeft >= hidden - 2);
  };
  table.addEventListener('scroll', look);
  window.addEventListener('resize', look);
  box.closest('details')?.addEventListener('toggle', look);
  look();
}
for (const figure of document.querySelectorAll('figure.picture')) {
  figure.addEventListener('click', () => figure.classList.toggle('wide'));
}
