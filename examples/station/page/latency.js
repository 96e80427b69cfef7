// From the hand to the picture, by the browser's own clock alone: input's stamp to the frame that obeys it, drawn.

const edges = [5, 10, 15, 20, 30, 40, 50, 75, 100, 125, 150, 200, 300, 500];  // upper ends of the bars [ms]

const kept = 100000;  // percentiles are of the last so many

export class Latency {
  constructor() {
    this.limit = 150;
    this.clear();
  }

  clear() {
    Object.assign(this, {counts: new Array(edges.length + 1).fill(0), total: 0, late: 0, worst: 0, sortedOf: 0});
    this.samples ??= new Float64Array(kept);
  }

  // [ms]
  add(value) {
    ++this.total;
    if (value > this.limit) ++this.late;
    this.worst = Math.max(this.worst, value);
    const bar = edges.findIndex(edge => value <= edge);
    ++this.counts[bar < 0 ? edges.length : bar];
    this.samples[(this.total - 1) % kept] = value;
  }

  // Nearest rank: the least value that this share of all does not exceed.
  percentile(share) {
    // Sorted once for all shares, as numbers: by a function that compares 100 000 take longer than a picture.
    if (this.sortedOf !== this.total) Object.assign(this, {sorted: this.samples.slice(0, Math.min(this.total, kept)).sort(), sortedOf: this.total});
    return this.total ? this.sorted[Math.max(0, Math.ceil(share * this.sorted.length) - 1)] : NaN;
  }

  // Bars of equal width with the limit's line, as SVG.
  draw(svg) {
    const width = 300, height = 84, foot = 16, top = Math.max(1, ...this.counts), bar = width / this.counts.length;
    const limitAt = bar * (edges.indexOf(this.limit) + 1);
    // A square root, so that one late frame among thousands is still seen.
    const bars = this.counts.map((count, i) => {
      const tall = count ? Math.max(2, Math.sqrt(count / top) * (height - foot - 4)) : 0;
      const name = i < edges.length ? `up to ${edges[i]} ms` : `over ${edges[edges.length - 1]} ms`;
      return `<rect class="${i < edges.length && edges[i] <= this.limit ? 'in' : 'late'}" x="${(i * bar + 1).toFixed(1)}" ` +
        `y="${(height - foot - tall).toFixed(1)}" width="${(bar - 2).toFixed(1)}" height="${tall.toFixed(1)}"><title>${count}, ${name}</title></rect>`;
    });
    const labels = [10, 20, 50, 100, 150, 500].map(value => `<text x="${(bar * (edges.indexOf(value) + 1)).toFixed(1)}" y="${height - 3}" ` +
      `text-anchor="middle">${value}</text>`);
    svg.setAttribute('viewBox', `0 0 ${width} ${height}`);
    svg.innerHTML = bars.join('') + labels.join('') + `<line class="axis" x1="0" x2="${width}" y1="${height - foot}" y2="${height - foot}"/>` +
      `<line class="limit" x1="${limitAt}" x2="${limitAt}" y1="0" y2="${height - foot}"/>`;
  }
}
