// Tests ask the page these questions from within.
window.seen = {
  // x of the tip as `method` shows it.
  tip: method => touchstoneStation.station.frame.methods[method].poses[8],

  // The colour at a point of the world on the first screen, as it is drawn: [r, g, b] from 0 to 255.
  colourAt(point) {
    const {station, picture, renderer} = touchstoneStation, screen = station.screens[0];
    picture.draw(station.frame, station.screens, 'dark');
    const at = picture.place(screen, point);
    const x = at[0] * renderer.ratio, y = renderer.canvas.height - at[1] * renderer.ratio;
    const pixel = new Uint8Array(4);
    renderer.gl.readPixels(Math.round(x), Math.round(y), 1, 1, renderer.gl.RGBA, renderer.gl.UNSIGNED_BYTE, pixel);
    return [...pixel.slice(0, 3)];
  },

  // Inputs that reached the station since `from`.
  inputs: (from = 0) => fake.received.slice(from).filter(message => message.type === 'input'),
  controls: () => fake.received.filter(message => message.type === 'control'),

  // A saved flight's bytes, of these texts and frames.
  flight({texts, frames}) {
    const text = new TextEncoder().encode(typeof texts === 'string' ? texts : JSON.stringify(texts));
    return new Blob(['TSR1', new Uint32Array([text.length]), text, ...frames.flatMap(frame => [new Uint32Array([frame.byteLength]), frame])]);
  },

  // The shown frame, to be saved.
  shown() {
    const {station: {hello, scene}, timeline} = touchstoneStation;
    return {texts: structuredClone({hello, scene}), frames: [...timeline.frames]};
  },

  // Opens a file as by hand.
  openFile(bytes) {
    const chosen = new DataTransfer(), input = document.getElementById('open');
    chosen.items.add(new File([bytes], 'flight.tsf'));
    input.files = chosen.files;
    input.dispatchEvent(new Event('change'));
  },

  // Texts whose contrast to what lies behind is less than WCAG 2.2's 4.5 to 1 (large or bold ones 3 to 1).
  faint() {
    const parse = colour => { const [r, g, b, a = 1] = colour.match(/[\d.]+/g).map(Number); return {rgb: [r, g, b], a}; };
    const light = rgb => { const [r, g, b] = rgb.map(c => { c /= 255; return c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; }); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
    const behind = node => { for (; node; node = node.parentElement) { const {rgb, a} = parse(getComputedStyle(node).backgroundColor); if (a > 0.7) return rgb; } return [255, 255, 255]; };
    const found = [];
    for (const node of document.querySelectorAll('body *')) {
      const own = [...node.childNodes].some(child => child.nodeType === 3 && child.textContent.trim());
      if (!own || !node.checkVisibility() || node.closest('svg, noscript, option')) continue;
      const style = getComputedStyle(node), [a, b] = [light(parse(style.color).rgb), light(behind(node))].sort((x, y) => y - x);
      const large = parseFloat(style.fontSize) >= 24 || (parseFloat(style.fontSize) >= 18.66 && Number(style.fontWeight) >= 700);
      const ratio = (a + 0.05) / (b + 0.05);
      if (ratio < (large ? 3 : 4.5)) found.push(`${node.tagName} ${node.id} "${node.textContent.trim().slice(0, 30)}" ${ratio.toFixed(2)}`);
    }
    return found;
  },

  // Things to press or choose that have no name for a screen reader.
  nameless: () => [...document.querySelectorAll('button, select, input, [role=img]')].filter(node =>
    !(node.textContent.trim() && node.tagName === 'BUTTON') && !node.getAttribute('aria-label') && !node.title &&
    !(node.labels && [...node.labels].some(label => label.textContent.trim()))).map(node => node.outerHTML.slice(0, 80)),

  // Things to press or choose smaller than 24 px (WCAG 2.2, 2.5.8).
  small: () => [...document.querySelectorAll('button, select')].filter(node => node.checkVisibility()).filter(node => {
    const {width, height} = node.getBoundingClientRect(); return width < 24 || height < 24; }).map(node => node.outerHTML.slice(0, 80))
};
