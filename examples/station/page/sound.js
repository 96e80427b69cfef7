// The cue as a tone: pulses that quicken as things come near, a steady tone in contact, a lower one where motion is blocked.

const tones = {clear: [0, 0], near: [660, 0.06], contact: [880, 0.1], blocked: [330, 0.12]};

export class Sound {
  constructor() {
    this.on = true;
    this.cue = 'clear';
    // Browsers let a page sound only after a key or a click.
    for (const name of ['keydown', 'pointerdown']) addEventListener(name, () => this.start(), {once: true});
  }

  start() {
    if (this.context || !window.AudioContext) return;
    this.context = new AudioContext();
    this.oscillator = this.context.createOscillator();
    this.oscillator.type = 'triangle';
    this.gain = this.context.createGain();
    this.gain.gain.value = 0;
    this.oscillator.connect(this.gain).connect(this.context.destination);
    this.oscillator.start();
    this.context.resume();
    this.apply();
  }

  // `nearness`: 0 far, 1 touching.
  set(cue, nearness = 0) {
    this.cue = cue;
    this.nearness = nearness;
    this.apply();
  }

  apply() {
    const [pitch, loud] = this.on ? tones[this.cue] : [0, 0];
    const period = 700 - 550 * (this.nearness || 0);
    const sounds = loud > 0 && (this.cue !== 'near' || performance.now() % period < 90);
    document.documentElement.dataset.tone = loud > 0 ? this.cue : 'silent';
    if (!this.context) return;
    if (pitch) this.oscillator.frequency.setTargetAtTime(pitch, this.context.currentTime, 0.005);
    this.gain.gain.setTargetAtTime(sounds ? loud : 0, this.context.currentTime, 0.008);
  }
}
