// decide(), sentence(), headline() and reason_out() of verdict.cpp once more, from the same counts and with the same
// texts; the tests hold both against each other. Nothing here touches the page.

// How figures are written, as the tables of the program have them.
function touchstoneFigures() {
  'use strict';
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
  const three = v => general(v, 3);
  const percent = share => general(100 * share, 100 * share < 99.5 ? 2 : 3);
  const thousands = v => String(v).replace(/\B(?=(\d{3})+$)/g, ' ');
  function nanoseconds(v) {
    if (isNaN(v)) return '-';
    return v < 99.95 ? (tieEven(10 * v) / 10).toFixed(1) : thousands(Math.round(v));
  }
  function metres(v) {
    if (isNaN(v)) return '-';
    if (v === 0) return '0';
    if (v > 0 && v < 2.2250738585072014e-308) return '> 0';
    return isFinite(v) ? exponent(exponential(v, 1)) : 'inf';
  }
  return {three, percent, thousands, nanoseconds, metres};
}

// The counts of the report by stratum (class, separation, distance from the origin), and which of them a choice takes.
function touchstoneStrata(data) {
  'use strict';
  const alphabet = 'ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/';
  const bands = ['apart', 'touching', 'deep'];
  const codes = [0];
  for (let c = 1; c < data.last_code; ++c) {
    codes.push(Number((10 + (c - 1) % data.codes_a_decade) + 'e' +
                      (data.first_exponent + Math.floor((c - 1) / data.codes_a_decade))));
  }
  codes.push(Infinity);
  function strata(text, query) {
    // A number is digits of 5 bits, the least first; the last one is below 32.
    let at = 0;
    const next = () => {
      for (let value = 0, factor = 1;; factor *= 32) {
        const digit = alphabet.indexOf(text[at++]);
        value += digit % 32 * factor;
        if (digit < 32) return value;
      }
    };
    // Costs of what is asked (value, normals, points, both), counted by bins of coverage; no bins: as before.
    const asked = before => {
      const one = {missing: next(), worst: codes[next()], index: next(), reason: data.reasons[next()], counts: []};
      const bins = next();
      if (bins === 0 && before) one.counts = before.counts;
      for (let b = 0; b < bins; ++b) {
        const bin = next();
        for (let left = next(), code = 0; left > 0; --left) {
          code += next();
          one.counts.push([bin, codes[code], next()]);
        }
      }
      return one;
    };
    // The strata, one after the other.
    const list = [];
    while (at < text.length) {
      const one = {band: bands[next()], apart: next(), within: next(), cases: next(), missed: next(),
                   phantom: next(), undecided: next(), failed: next(), unsupported: next(), asked: []};
      for (let a = 0; a < (query === 'overlap' ? 1 : 4); ++a) one.asked.push(asked(one.asked[a - 1]));
      list.push(one);
    }
    return list;
  }
  // Read when first asked for: a verdict is of one query.
  const read = new Map();
  function strataOf(answers, query) {
    if (!read.has(answers)) read.set(answers, strata(answers.curves, query));
    return read.get(answers);
  }
  function binOf(value, bins) {
    const bin = bins.findIndex(end => end >= value);
    return bin < 0 ? bins.length : bin;
  }
  function upperEnd(limit, bins) {
    const bin = binOf(limit, bins);
    return bin < bins.length ? bins[bin] : Infinity;
  }
  function has(choice, stratum) {
    if (stratum.within > binOf(choice.within, data.within_bins_m)) return false;
    if (!choice[stratum.band]) return false;
    return stratum.band !== 'apart' || stratum.apart <= binOf(choice.apart_up_to, data.apart_bins_m);
  }
  return {strataOf, binOf, upperEnd, has};
}

// The 95 % bound of Clopper and Pearson on a share, as upper_bound.cpp: `k` of `n` cases are beyond.
function touchstoneUpperBound(k, n) {
  'use strict';
  function logGamma(x) {  // Stirling's series, good to doubles from 15 on
    let shift = 0;
    for (; x < 15; ++x) shift -= Math.log(x);
    const i = 1 / x, i2 = i * i;
    return shift + (x - 0.5) * Math.log(x) - x + 0.5 * Math.log(2 * Math.PI) +
      i * (1 / 12 - i2 * (1 / 360 - i2 * (1 / 1260 - i2 / 1680)));
  }
  if (k >= n) return 1;
  if (k === 0) return -Math.expm1(Math.log(0.05) / n);
  const ways = logGamma(n + 1) - logGamma(k + 1) - logGamma(n - k + 1);
  const atMost = share => {
    let term = Math.exp(ways + k * Math.log(share) + (n - k) * Math.log1p(-share)), sum = term;
    for (let i = k; i > 0 && term > sum * Math.pow(2, -60); --i) {
      term *= i * (1 - share) / ((n - i + 1) * share);
      sum += term;
    }
    return sum;
  };
  let low = k / n, high = 1;
  for (let step = 0; step < 60; ++step) {
    const middle = (low + high) / 2;
    if (atMost(middle) > 0.05) low = middle; else high = middle;
  }
  return high;
}

// decide(choice): every backend's counts and costs over the sets that the choice takes, the first one first.
function touchstoneVerdicts(data, strata) {
  'use strict';
  const {strataOf, binOf, has} = strata;
  const number = v => v === 'inf' ? Infinity : v === null ? NaN : v;
  const askedOf = choice => choice.query === 'overlap' ? 0 : (choice.normals ? 1 : 0) + (choice.points ? 2 : 0);
  const larger = (x, y) => isNaN(x) || isNaN(y) ? NaN : Math.max(x, y);
  function sumUp(sets, name, choice) {
    // Counts and costs of all sets that the choice takes.
    const c = {backend: name, ns: 0, p999: 0, allocations: 0, cases: 0, missed: 0, phantom: 0, undecided: 0,
               failed: 0, unsupported: 0, missing: 0, beyond: 0, worst: 0, id: '', reason: '', gap: ''};
    const needed = choice.query === 'manifold' ? binOf(choice.min_coverage, data.coverage_bins) : 0;
    for (const set of sets) {
      const found = set.backends.find(b => b.backend === name);
      if (!found) {
        c.gap = c.gap || set.name;
        continue;
      }
      const answers = found.queries[choice.query];
      c.ns += number(answers.ns);
      c.p999 = larger(c.p999, number(answers.p999_ns));
      c.allocations = larger(c.allocations, number(answers.allocations));
      for (const s of strataOf(answers, choice.query)) {
        if (!has(choice, s)) continue;
        const asked = s.asked[askedOf(choice)];
        for (const key of ['cases', 'missed', 'phantom', 'undecided', 'failed', 'unsupported']) c[key] += s[key];
        c.missing += asked.missing;
        for (const [bin, cost, count] of asked.counts)
          if (bin < needed || cost > choice.max_error) c.beyond += count;
        if (asked.worst > c.worst) {
          c.worst = asked.worst;
          c.id = set.ids[asked.index] || '';
          c.reason = asked.reason;
        }
      }
    }
    // Shares and means of them, and whether the backend is inside all limits.
    c.ns = c.gap ? NaN : c.ns / sets.length;
    c.supported = c.cases - c.unsupported;
    c.share = c.supported === 0 ? 0 : c.beyond / c.supported;
    c.wrong = c.missed + c.phantom + c.undecided + c.failed + c.missing;
    c.complete = c.wrong === 0 && c.unsupported === 0;
    c.inside = !c.gap && c.unsupported === 0 && c.beyond <= choice.share * c.cases && isFinite(c.ns) &&
      (choice.deadline === Infinity || c.p999 <= choice.deadline * 1e9) &&
      (!choice.no_allocations || c.allocations === 0);
    return c;
  }
  function before(x, y) {
    if (x.inside !== y.inside) return x.inside ? -1 : 1;
    if (x.inside) return x.ns - y.ns;
    const answeredX = !x.gap && x.unsupported === 0, answeredY = !y.gap && y.unsupported === 0;
    if (answeredX !== answeredY) return answeredX ? -1 : 1;
    if (x.share !== y.share) return x.share - y.share;
    return x.worst < y.worst ? -1 : x.worst > y.worst ? 1 : 0;
  }
  function casesIn(set, choice) {
    if ((choice.sets.length > 0 && !choice.sets.includes(set.name)) || set.backends.length === 0) return 0;
    return strataOf(set.backends[0].queries[choice.query], choice.query)
      .reduce((sum, s) => sum + (has(choice, s) ? s.cases : 0), 0);
  }
  function decide(choice) {
    const verdict = {choice, cases: 0, all: 0, candidates: []}, sets = [], names = [];
    for (const set of data.sets) {
      verdict.all += set.cases;
      const cases = casesIn(set, choice);
      if (cases === 0) continue;
      verdict.cases += cases;
      sets.push(set);
      for (const b of set.backends) if (!names.includes(b.backend)) names.push(b.backend);
    }
    verdict.candidates = names.map(name => sumUp(sets, name, choice)).sort(before);
    verdict.first = verdict.candidates.length && verdict.candidates[0].inside ? verdict.candidates[0] : null;
    return verdict;
  }
  return decide;
}

// A verdict in words, from the texts of verdict.cpp.
function touchstoneWords(data, figures, strata) {
  'use strict';
  const {three, percent, thousands, nanoseconds, metres} = figures, {upperEnd} = strata;
  const fill = (name, values) => data.texts[name].replace(/\{(\w+)\}/g, (all, key) => values[key]);
  function domainText(choice) {
    const parts = [], classes = (choice.apart ? 1 : 0) + (choice.touching ? 2 : 0) + (choice.deep ? 4 : 0);
    if (classes !== 7) parts.push(fill('classes_' + classes));
    const apart = upperEnd(choice.apart_up_to, data.apart_bins_m), within = upperEnd(choice.within, data.within_bins_m);
    if (choice.apart && isFinite(apart)) parts.push(fill('apart_up_to', {limit: three(apart)}));
    if (isFinite(within)) parts.push(fill('within', {limit: three(within)}));
    if (choice.query !== 'overlap') {
      if (!choice.normals) parts.push(fill('without_normals'));
      if (!choice.points) parts.push(fill('without_points'));
    }
    if (choice.query === 'manifold' && choice.min_coverage > 0)
      parts.push(fill('coverage', {coverage: three(upperEnd(choice.min_coverage, data.coverage_bins))}));
    if (isFinite(choice.deadline)) parts.push(fill('deadline', {deadline: three(choice.deadline)}));
    if (choice.no_allocations) parts.push(fill('no_allocations'));
    if (choice.sets.length > 0) parts.push(fill('sets', {names: choice.sets.join(', ')}));
    return parts.length === 0 ? '' : fill('domain', {parts: parts.join(', ')});
  }
  function wrongWords(c) {
    const parts = [];
    [[c.missed, 'missed'], [c.phantom, 'phantom'], [c.undecided, 'undecided'], [c.failed, 'failed'],
     [c.missing, 'no value']].forEach(([count, kind]) => {
       if (count > 0) parts.push(fill('wrong_kind', {count: thousands(count), kind}));
     });
    if (parts.length === 0 && c.supported > 0) parts.push(fill('wrong_none', {cases: thousands(c.supported)}));
    if (c.unsupported > 0) parts.push(fill('unsupported', {count: thousands(c.unsupported)}));
    return parts.length === 0 ? fill('wrong_none', {cases: '0'}) : parts.join(', ');
  }
  function sentence(verdict) {
    const choice = verdict.choice, all = thousands(verdict.all), domain = domainText(choice);
    if (verdict.cases === 0) return fill('empty', {all, domain});
    const which = choice.share === 0 ? fill('every', {query: choice.query})
                                     : fill('all_but', {share: percent(choice.share), query: choice.query});
    const said = {error: three(choice.max_error), which, domain, cases: thousands(verdict.cases), all};
    const first = verdict.first;
    if (!first) return fill('none', said);
    const bound = percent(touchstoneUpperBound(first.beyond, first.supported));
    said.backend = first.backend;
    said.ns = nanoseconds(first.ns);
    said.with = first.wrong === 0 ? '' : fill('with', {wrong: wrongWords(first)});
    said.beyond = first.beyond === 0 ? fill('beyond_none', {bound})
                                     : fill('beyond_some', {share: percent(first.share), bound});
    return fill('fastest', said);
  }
  function headline(verdict) {
    const first = verdict.first;
    if (!first) return '';
    return fill('headline', {backend: first.backend, ns: nanoseconds(first.ns), wrong: wrongWords(first)}) +
      verdict.candidates.slice(1).map(c => {
        const ratio = c.ns / first.ns;
        const speed = !isFinite(ratio) || !c.complete ? '' : ratio >= 1 ? fill('slower', {ratio: three(ratio)})
                                                                       : fill('faster', {ratio: three(1 / ratio)});
        return fill('other', {backend: c.backend, speed, wrong: wrongWords(c)});
      }).join('');
  }
  function reasonBeyond(choice, c) {
    if (c.worst <= choice.max_error) return fill('out_coverage');
    return fill(metres(c.worst) === metres(choice.max_error) ? 'out_just_over' : 'out_beyond',
                {reason: c.reason, case: c.id});
  }
  function reason(verdict, c) {
    const choice = verdict.choice;
    if (c.inside) return c === verdict.first ? fill('first') : fill('ratio', {ratio: three(c.ns / verdict.first.ns)});
    if (c.gap) return fill('out_missing', {set: c.gap});
    if (c.unsupported > 0) return fill('out_unsupported', {count: thousands(c.unsupported), cases: thousands(c.cases)});
    if (c.beyond > choice.share * c.cases) return reasonBeyond(choice, c);
    if (!isFinite(c.ns)) return fill('out_untimed');
    if (isFinite(choice.deadline) && isNaN(c.p999)) return fill('out_few_calls');
    if (isFinite(choice.deadline) && c.p999 > choice.deadline * 1e9)
      return fill('out_deadline', {p999: nanoseconds(c.p999)});
    if (isNaN(c.allocations)) return fill('out_uncounted');
    return fill('out_allocations', {allocations: three(c.allocations)});
  }
  return {sentence, headline, reason};
}

function touchstoneDecider(data) {
  'use strict';
  const figures = touchstoneFigures(), strata = touchstoneStrata(data);
  const decide = touchstoneVerdicts(data, strata);
  const {sentence, headline, reason} = touchstoneWords(data, figures, strata);
  const {three, percent, thousands, nanoseconds, metres} = figures;
  const kinds = ['overlap', 'distance', 'manifold'];
  // The cells beside the backend's name.
  function cells(verdict, c) {
    const time = nanoseconds(c.ns);
    return [c.inside ? 'yes' : 'no', c.complete || isNaN(c.ns) ? time : '(' + time + ')', nanoseconds(c.p999),
            isNaN(c.allocations) ? '-' : three(c.allocations),
            c.beyond === 0 ? '0' : thousands(c.beyond) + ' (' + percent(c.share) + ' %)',
            metres(c.worst), reason(verdict, c)];
  }
  return {decide, sentence, headline, cells, kinds};
}
