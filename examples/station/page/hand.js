// The hands' input: keyboard, gamepad and the page's own buttons, as six axes, the jaws' and a joint's rate, each from -1 to 1.
// Two-handed, as the SSRMS's hand controllers: the left one translates, the right one rotates.

// Physical keys, so that they lie in the same places on every keyboard: [vector, axis, sign]. Axes: forward, left, up.
const axes = {
  KeyW: ['translation', 0, 1], KeyS: ['translation', 0, -1], KeyA: ['translation', 1, 1], KeyD: ['translation', 1, -1],
  KeyR: ['translation', 2, 1], KeyF: ['translation', 2, -1],
  KeyJ: ['rotation', 2, 1], KeyL: ['rotation', 2, -1], KeyI: ['rotation', 1, -1], KeyK: ['rotation', 1, 1],
  KeyU: ['rotation', 0, -1], KeyO: ['rotation', 0, 1],
  KeyQ: ['grip', 0, 1], KeyE: ['grip', 0, -1]};

// Buttons of the standard gamepad mapping that do something once when pressed.
const padCommands = {0: 'latch', 1: 'release', 2: 'vernier', 3: 'frame', 8: 'compare', 9: 'brakes', 10: 'mode', 11: 'reset',
  14: 'joint-back', 15: 'joint-on'};

const deadZone = 0.12;
// Past the dead zone the response starts at zero and is squared: fine near the middle.
export function shape(value) {
  const size = Math.min(1, Math.max(0, (Math.abs(value) - deadZone) / (1 - deadZone)));
  return Math.sign(value) * size * size;
}

// Where typing or choosing belongs to an element of the page, not to the arm.
const typing = target => target instanceof Element && target.matches('input, select, textarea, dialog[open] *');

export class Hand {
  // `onCommand(name)`: of what is pressed once. `onChange()`: at once when a key changes what is held.
  constructor(commands, onCommand, onChange) {
    Object.assign(this, {commands, onCommand, onChange, held: new Set(), pressed: new Map(), padButtons: [], enabled: true, assist: null});
    addEventListener('keydown', event => this.down(event));
    addEventListener('keyup', event => { if (this.held.delete(event.code)) this.onChange(); });
    addEventListener('blur', () => this.letGo());
    document.addEventListener('visibilitychange', () => { if (document.hidden) this.letGo(); });
  }

  letGo() {
    this.held.clear();
    this.pressed.clear();
    this.assist = null;
  }

  down(event) {
    if (!this.enabled || event.ctrlKey || event.altKey || event.metaKey || typing(event.target)) return;
    if (event.code in axes) {
      event.preventDefault();
      if (this.held.has(event.code)) return;
      this.held.add(event.code);
      this.assist = null;
      this.onChange();
    } else if (event.code in this.commands && !event.repeat) {
      if (event.target instanceof HTMLButtonElement && (event.code === 'Space' || event.code === 'Enter')) return;
      this.onCommand(this.commands[event.code]);
      event.preventDefault();
    }
  }

  // A button of the page that holds an axis while it is pressed.
  bindButton(button) {
    const code = button.dataset.axis;
    const hold = event => { this.pressed.set(button, code); this.assist = null; if (event.pointerId) button.setPointerCapture(event.pointerId); };
    const free = () => this.pressed.delete(button);
    button.addEventListener('pointerdown', hold);
    for (const name of ['pointerup', 'pointercancel', 'lostpointercapture', 'blur']) button.addEventListener(name, free);
    button.addEventListener('keydown', event => { if (event.code === 'Space' || event.code === 'Enter') { event.preventDefault(); hold(event); } });
    button.addEventListener('keyup', free);
    button.addEventListener('contextmenu', event => event.preventDefault());
  }

  readPad(state) {
    const pads = navigator.getGamepads ? Array.from(navigator.getGamepads()) : [];
    const pad = pads.find(one => one && one.connected);
    this.padName = pad ? pad.id : '';
    if (!pad) return;
    const value = i => pad.buttons[i] ? pad.buttons[i].value : 0;
    const [lx, ly, rx, ry] = [0, 1, 2, 3].map(i => shape(pad.axes[i] || 0));
    const read = [-ly, -lx, value(7) - value(6), value(5) - value(4), ry, -rx];
    for (let i = 0; i < 3; ++i) {
      state.translation[i] += read[i];
      state.rotation[i] += read[3 + i];
    }
    state.grip[0] += value(12) - value(13);
    pad.buttons.forEach((button, i) => {
      if (button.pressed && !this.padButtons[i] && i in padCommands) this.onCommand(padCommands[i]);
      this.padButtons[i] = button.pressed;
    });
  }

  // The state of all, now.
  read() {
    const state = {translation: [0, 0, 0], rotation: [0, 0, 0], joint: 0, grip: [0]};
    for (const code of new Set([...this.held, ...this.pressed.values()])) {
      const [vector, axis, sign] = axes[code];
      state[vector][axis] += sign;
    }
    if (this.enabled) this.readPad(state);
    const held = state.translation.some(Boolean) || state.rotation.some(Boolean);
    if (held) this.assist = null;
    if (this.assist && !held) state.translation = this.assist;
    for (const vector of [state.translation, state.rotation, state.grip])
      for (let i = 0; i < vector.length; ++i) vector[i] = Math.max(-1, Math.min(1, vector[i]));
    state.joint = state.translation[0];
    state.grip = state.grip[0];
    return state;
  }
}
