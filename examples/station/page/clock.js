// The station's clock as the browser's plus an offset. Nothing arrives before it was sent: each message from here bounds the offset from
// above, each one from there from below. The least of the one and the greatest of the other, of the last seconds, need not be of one
// exchange, so that an answer which waited until the page's turn had ended spoils none. All in us.

const kept = 20, second = 1e6;  // bounds of so many seconds count: two hosts' clocks drift apart by some 50 us a second
const near = 2000;              // a width up to which a ping a second will do

export class Clock {
  constructor() {
    this.forget();
  }

  // Of another connection.
  forget() {
    this.seconds = [];
  }

  // Of `seconds` the newest is last.
  bound(now, above, below) {
    let last = this.seconds.at(-1);
    if (!last || now - last.from >= second) {
      this.seconds.push(last = {from: now, above: Infinity, below: -Infinity});
      if (this.seconds.length > kept) this.seconds.shift();
    }
    if (above < last.above) last.above = above;
    if (below > last.below) last.below = below;
  }

  // Sent from here at `stamp`, received there at `received`; said here at `now`.
  there(now, stamp, received) {
    if (Number.isFinite(stamp) && Number.isFinite(received)) this.bound(now, received - stamp, -Infinity);
  }

  // Sent from there at `sent`, arrived here at `now`.
  here(now, sent) {
    if (Number.isFinite(sent)) this.bound(now, Infinity, sent - now);
  }

  // `offset`: station = browser + offset, wrong by at most half of `rtt`, the width that the bounds leave; where clocks drift these cross.
  get known() {
    const above = Math.min(...this.seconds.map(one => one.above)), below = Math.max(...this.seconds.map(one => one.below));
    if (!Number.isFinite(above) || !Number.isFinite(below)) return {offset: 0, rtt: Infinity};
    return {offset: (above + below) / 2, rtt: Math.abs(above - below)};
  }

  // Until the next ping [ms]: more often where little is known.
  get untilPing() {
    return this.known.rtt > near ? 100 : 1000;
  }
}
