// The slider: decide(), sentence(), headline() and reason_out() of verdict.cpp once more, on the same numbers.
// The tests hold both against each other.
(function () {
'use strict';
const source = document.getElementById('candidates');
if (!source) return;
const queries = JSON.parse(source.textContent);
const form = document.getElementById('controls'), query = document.getElementById('query');
const slider = document.getElementById('slider'), budget = document.getElementById('budget');
const chosen = document.getElementById('chosen'), fixed = document.getElementById('static-verdicts');
const number = v => v === 'inf' ? Infinity : v === null ? NaN : v;
const marks = {};
document.querySelectorAll('.legend [data-backend]').forEach(e => {
  marks[e.dataset.backend] = e.querySelector('svg');
});
// As toExponential, but of two decimals equally near the even one.
function exponential(v, digits) {
  const whole = v.toExponential(60), e = whole.indexOf('e');
  const all = whole.slice(0, e).replace('.', '');
  if (!/^50*$/.test(all.slice(digits + 1)) || Number(all[digits]) % 2 === 1) return v.toExponential(digits);
  return all[0] + (digits > 0 ? '.' + all.slice(1, digits + 1) : '') + whole.slice(e);
}
const exponent = text => text.replace(/e([+-])(\d)$/, 'e$10$2');
function tieEven(v) {
  const low = Math.floor(v);
  return v - low === 0.5 ? low + (low % 2) : Math.round(v);
}
function general(v, digits) {
  if (v === 0) return '0';
  if (!isFinite(v)) return isNaN(v) ? 'nan' : 'inf';
  const scientific = exponential(v, digits - 1);
  const power = Number(scientific.slice(scientific.indexOf('e') + 1));
  const trim = t => t.includes('.') ? t.replace(/0+$/, '').replace(/\.$/, '') : t;
  if (power < -4 || power >= digits) {
    const parts = scientific.split('e');
    return exponent(trim(parts[0]) + 'e' + parts[1]);
  }
  return trim(Number(scientific).toFixed(Math.max(digits - 1 - power, 0)));
}
const thousands = v => String(v).replace(/\B(?=(\d{3})+$)/g, ' ');
function nanoseconds(v) {
  if (isNaN(v)) return '-';
  return v < 99.95 ? (tieEven(10 * v) / 10).toFixed(1) : thousands(Math.round(v));
}
function error(v) {
  if (isNaN(v)) return '-';
  if (v === 0) return '0';
  return isFinite(v) ? exponent(exponential(v, 1)) : 'inf';
}
function decide(name, allowed) {
  const list = queries.find(q => q.query === name).candidates.map(c => Object.assign({}, c, {
    ns: number(c.mean_ns), cost: number(c.worst_cost_m)
  }));
  list.forEach(c => { c.inside = c.cost <= allowed && isFinite(c.ns); });
  list.sort((x, y) => {
    if (x.inside !== y.inside) return x.inside ? -1 : 1;
    const a = x.inside ? x.ns : x.cost, b = x.inside ? y.ns : y.cost;
    return a < b ? -1 : a > b ? 1 : 0;
  });
  return list;
}
function sentence(name, allowed, list) {
  const asked = 'within ' + general(allowed, 3) + ' m on every ' + name + ' case';
  if (!list.length || !list[0].inside) return 'no backend stays ' + asked;
  return 'fastest ' + asked + ': ' + list[0].backend + ', ' + tieEven(list[0].ns) + ' ns a pair' +
    (list[0].wrong === 0 ? '' : ', with ' + list[0].wrong_words);
}
function headline(list) {
  const first = list[0];
  return first.backend + ', ' + nanoseconds(first.ns) + ' ns a pair, ' + first.wrong_words +
    list.slice(1).map(c => {
      const ratio = c.ns / first.ns;
      const speed = !isFinite(ratio) || c.wrong > 0 ? '' : ratio >= 1 ? ' is ' + general(ratio, 3) + ' times slower,'
                                                   : ' is ' + general(1 / ratio, 3) + ' times faster,';
      return '; ' + c.backend + speed + ' ' + c.wrong_words;
    }).join('');
}
function reason(list, allowed, c) {
  if (c.cost > allowed) {
    const what = c.worst_reason || 'error';
    if (error(c.cost) === error(allowed)) return what + ' costs just over the allowed error in ' + c.worst_case;
    return isFinite(c.cost) ? what + ' costs ' + error(c.cost) + ' m in ' + c.worst_case
                            : what + ' in ' + c.worst_case;
  }
  if (!c.inside) return 'not timed in every set';
  if (c === list[0]) return 'the fastest inside';
  return general(c.ns / list[0].ns, 3) + ' times slower';
}
function element(tag, text, parent) {
  const e = document.createElement(tag);
  if (text !== null) e.textContent = text;
  parent.appendChild(e);
  return e;
}
function table(list, allowed) {
  const body = document.createElement('table');
  body.className = 'ranked';
  const head = element('tr', null, element('thead', null, body));
  ['backend', 'inside', 'ns a pair', 'worst [m]', 'why', 'case', 'wrong'].forEach(t => element('th', t, head));
  const rows = element('tbody', null, body);
  list.forEach(c => {
    const row = element('tr', null, rows);
    if (!c.inside) row.className = 'out';
    const name = element('th', null, row);
    if (marks[c.backend]) name.appendChild(marks[c.backend].cloneNode(true));
    name.appendChild(document.createTextNode(c.backend));
    const time = nanoseconds(c.ns);
    [c.inside ? 'yes' : 'no', c.wrong === 0 || isNaN(c.ns) ? time : '(' + time + ')', error(c.cost),
     reason(list, allowed, c), c.worst_case, thousands(c.wrong)].forEach(t => element('td', t, row));
  });
  return body;
}
function show() {
  const allowed = Number(budget.value);
  chosen.replaceChildren();
  if (budget.value.trim() === '' || !(allowed >= 0) || !isFinite(allowed)) {
    element('p', 'The allowed error is a number of metres, not negative.', chosen).className = 'gap';
    return;
  }
  const list = decide(query.value, allowed);
  element('strong', sentence(query.value, allowed, list), chosen).id = 'sentence';
  if (list.length && list[0].inside) element('p', headline(list), chosen).id = 'headline';
  const scroll = element('div', null, chosen);
  scroll.className = 'scroll';
  scroll.appendChild(table(list, allowed));
}
function place() {
  const v = Number(budget.value);
  slider.value = v > 0 ? Math.log10(v) : slider.min;
}
slider.addEventListener('input', () => {
  budget.value = slider.value === slider.min ? '0' : Number(Math.pow(10, Number(slider.value)).toPrecision(2));
  show();
});
budget.addEventListener('input', () => { place(); show(); });
query.addEventListener('change', show);
form.addEventListener('submit', event => event.preventDefault());
form.hidden = false;
fixed.hidden = true;
place();
show();
})();
