// How much is drawn of a picture: less where drawing takes longer than its budget, more again where there is time.

// From drawing to its end, as the page's turns tell it [ms]: a third of the 150 ms from hand to picture. The station's step, the hand's
// own timer and a turn of the page that has to be waited for need the rest.
export const budget = 50;
const spare = 30;  // up to this there is time for more [ms]; up to what `turns` says where the page's turns are longer
// A picture's end is told by a turn, so that none takes less than one: up to one and a half of the shortest turn it took one.
const turns = 1.5, kept = 10000;  // the shortest of the last `kept` to twice as many ms
const judged = 12, late = 3;  // of so many pictures so many late: less
const farLate = 4 * budget, stalled = 16 * budget;  // a single one: less; the least, since each level would take seconds [ms]
const idle = 1000;  // a longer time without a picture says no more than so long [ms]
const calm = 4000, mostCalm = 64000;  // no picture above what is to spare for so long: more; twice as long where that was too much [ms]

// From all to least. `pixels`: share of the screen's, each way. `cctv`: so many of its pictures are drawn anew at a time, once in
// `every` pictures. `apart`: of pictures [ms]; fewer leave a busy processor to the station, and each comes sooner. `readOuts`: of the
// panels, a second.
export const levels = [
  {pixels: 1, cctv: Infinity, every: 1, edges: true, meshes: true, apart: 0, readOuts: 10},
  {pixels: 0.75, cctv: Infinity, every: 1, edges: true, meshes: true, apart: 0, readOuts: 10},
  {pixels: 0.75, cctv: 1, every: 1, edges: true, meshes: true, apart: 0, readOuts: 10},
  {pixels: 0.5, cctv: 1, every: 1, edges: true, meshes: false, apart: 0, readOuts: 5},
  {pixels: 0.5, cctv: 1, every: 3, edges: false, meshes: false, apart: 30, readOuts: 5},
  {pixels: 0.35, cctv: 1, every: 6, edges: false, meshes: false, apart: 30, readOuts: 3},
  {pixels: 0.25, cctv: 1, every: 12, edges: false, meshes: false, apart: 30, readOuts: 2}];
// Software begins below what it mostly holds: in its first seconds a page is compiled beside, and pictures take twice as long.
export const softwareStarts = 3;

export class Pace {
  // `software`: no graphics card draws.
  constructor(software = false) {
    Object.assign(this, {at: software ? softwareStarts : 0, fixed: null, wait: calm, raisedAt: -Infinity, shortest: Infinity, shortestBefore: Infinity});
    this.clock = 0;  // time in which pictures were drawn; `calmSince` and `raisedAt` are of it [ms]
    this.rest();
  }

  // Nothing is drawn for a while, nor do turns come: what is judged begins anew.
  rest() {
    Object.assign(this, {times: [], calmSince: null, addedAt: null, turnedAt: null});
  }

  // The page's turn at `now` [ms].
  turned(now) {
    if (this.turnedAt !== null) this.shortest = Math.min(this.shortest, now - this.turnedAt);
    this.turnedAt = now;
    if (now - (this.keptSince ??= now) > kept) Object.assign(this, {keptSince: now, shortestBefore: this.shortest, shortest: Infinity});
  }

  // Up to this a picture says that there is time for more [ms].
  get spare() {
    const turn = Math.min(this.shortest, this.shortestBefore);
    return turn < Infinity ? Math.min(budget, Math.max(spare, turns * turn)) : spare;
  }

  // `pixels`: null, or a share that was chosen: then nothing else is left out.
  fix(pixels) {
    this.fixed = pixels;
  }

  get level() { return levels[this.fixed ? 0 : this.at]; }
  get pixels() { return this.fixed ?? this.level.pixels; }

  // A picture that ended `now` took `took` [ms].
  add(took, now) {
    if (this.fixed) return;
    this.clock += Math.min(idle, now - (this.addedAt ?? now));
    this.addedAt = now;
    if (Number.isFinite(this.raisedAt) && this.clock - this.raisedAt > 4 * this.wait) this.wait = calm;  // it held
    this.times.push(took);
    if (this.times.length > judged) this.times.shift();
    if (this.calmSince === null || took > this.spare) this.calmSince = this.clock;
    if (took > farLate || this.times.filter(time => time > budget).length >= late) this.lower(took > stalled ? levels.length : 1);
    else if (this.clock - this.calmSince >= this.wait) this.raise();
  }

  lower(by) {
    // A step that was too much is tried again later, and taken back if it still is.
    if (this.clock - this.raisedAt < 2 * this.wait) this.wait = Math.min(mostCalm, 2 * this.wait);
    this.at = Math.min(levels.length - 1, this.at + by);
    Object.assign(this, {times: [], calmSince: this.clock, raisedAt: -Infinity});
  }

  raise() {
    if (this.at > 0) this.raisedAt = this.clock;
    this.at = Math.max(0, this.at - 1);
    Object.assign(this, {times: [], calmSince: this.clock});
  }

  // Names the parts that are left out; empty: none. `hasMeshes`: there are some to be left out.
  says(hasMeshes = false) {
    if (this.fixed) return this.fixed < 1 ? `drawn with ${this.fixed} of the pixels each way, as chosen` : '';
    const {pixels, cctv, every, edges, meshes, apart} = this.level;
    const said = [pixels < 1 && `${Math.round(100 * pixels)} % of the pixels each way`,
      cctv === 1 && (every > 1 ? `one CCTV picture in every ${every}` : 'one CCTV picture at a time'), !edges && 'no edges', hasMeshes && !meshes && 'hexahedra for meshes',
      apart > 0 && `at most ${Math.round(1000 / apart)} pictures a second`].filter(Boolean).join(', ');
    return said && `drawn for speed with ${said}`;
  }
}
