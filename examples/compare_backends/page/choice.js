(function () {
'use strict';
const source = document.getElementById('choices');
if (!source) return;
const data = JSON.parse(source.textContent), decider = touchstoneDecider(data);
const get = id => document.getElementById(id);
const form = get('controls'), chosen = get('chosen'), fixed = get('static-verdicts');
const marks = {};
document.querySelectorAll('.legend [data-backend]').forEach(e => {
  marks[e.dataset.backend] = e.querySelector('svg');
});
// A count of thousands stays on one line.
const together = text => text.replace(/(\d) (?=\d{3}(?!\d))/g, '$1\u00a0');
function element(tag, text, parent) {
  const e = document.createElement(tag);
  if (text !== null) e.textContent = together(text);
  parent.appendChild(e);
  return e;
}
function table(verdict) {
  const body = document.createElement('table');
  body.className = 'ranked';
  const head = element('tr', null, element('thead', null, body));
  JSON.parse(form.dataset.header).forEach(t => element('th', t, head));
  const rows = element('tbody', null, body);
  verdict.candidates.forEach(c => {
    const row = element('tr', null, rows);
    if (!c.inside) row.className = 'out';
    const name = element('th', null, row);
    if (marks[c.backend]) name.appendChild(marks[c.backend].cloneNode(true));
    name.appendChild(document.createTextNode(c.backend));
    decider.cells(verdict, c).forEach(t => element('td', t, row));
  });
  return body;
}
// A field that is left empty says nothing.
function numberIn(id, empty) {
  const text = get(id).value.trim();
  return text === '' ? empty : Number(text);
}
const boxes = [...document.querySelectorAll('#sets input')];
function choice() {
  const sets = boxes.filter(b => b.checked).map(b => b.value);
  return {query: get('query').value, sets: sets.length === boxes.length ? [] : sets, none: sets.length === 0,
          apart: get('apart').checked, touching: get('touching').checked, deep: get('deep').checked,
          apart_up_to: numberIn('apart_up_to', Infinity), within: numberIn('within', Infinity),
          normals: get('normals').checked, points: get('points').checked,
          max_error: numberIn('budget', NaN), share: numberIn('share', NaN),
          min_coverage: numberIn('coverage', 0), deadline: numberIn('deadline', Infinity),
          no_allocations: get('no_allocations').checked};
}
const faults = [
  [c => c.max_error >= 0 && isFinite(c.max_error), 'The allowed error is a number of metres, not negative.'],
  [c => c.share >= 0 && c.share < 1, 'The allowed share is a number from 0 to below 1.'],
  [c => c.deadline > 0, 'The deadline is a number of seconds above 0.'],
  [c => !c.none, 'No set is chosen.']];
function show() {
  const asked = choice();
  get('coverage_row').hidden = asked.query !== 'manifold';
  get('asked_figures').hidden = asked.query === 'overlap';
  chosen.replaceChildren();
  const fault = faults.find(([holds]) => !holds(asked));
  if (fault) {
    element('p', fault[1], chosen).className = 'gap';
    return;
  }
  const verdict = decider.decide(asked);
  element('strong', decider.sentence(verdict), chosen).id = 'sentence';
  if (verdict.cases === 0) return;
  if (verdict.first) element('p', decider.headline(verdict), chosen).id = 'headline';
  const scroll = element('div', null, chosen);
  scroll.className = 'scroll';
  scroll.appendChild(table(verdict));
}
// A slider of powers of ten beside its number; its lower end is 0.
function pair(slider, field) {
  const place = () => {
    const v = Number(field.value);
    slider.value = v > 0 ? Math.log10(v) : slider.min;
  };
  slider.addEventListener('input', () => {
    field.value = slider.value === slider.min ? '0' : Number(Math.pow(10, Number(slider.value)).toPrecision(2));
    show();
  });
  field.addEventListener('input', () => { place(); show(); });
  place();
  return place;
}
const places = [pair(get('slider'), get('budget')), pair(get('share_slider'), get('share'))];
get('coverage_slider').addEventListener('input', () => {
  get('coverage').value = data.coverage_bins[Number(get('coverage_slider').value)];
  show();
});
function contactsOnly() {
  get('apart').checked = false;
  get('touching').checked = get('deep').checked = true;
}
get('contacts_only').addEventListener('click', () => { contactsOnly(); show(); });
get('one_in_a_thousand').addEventListener('click', () => {
  get('budget').value = '1e-4';
  get('share').value = '1e-3';
  places.forEach(place => place());
  show();
});
form.addEventListener('change', show);
form.addEventListener('submit', event => event.preventDefault());
// On a phone the verdict is to be on the first screen.
get('more').open = innerWidth >= 800;
form.hidden = false;
fixed.hidden = true;
show();
})();
