// Looks back: keeps the frames that were shown (latest 64 MiB), saves them to a file and opens such files again.
// A file: "TSR1", bytes of the texts, hello and scene as JSON, then each frame with its size before it (u32, little-endian).

const limit = 64 * 1024 * 1024;

export class Timeline {
  constructor() {
    this.clear();
  }

  clear() {
    Object.assign(this, {frames: [], bytes: 0, opened: false});
  }

  add(buffer) {
    if (this.opened) return;
    this.frames.push(buffer);
    this.bytes += buffer.byteLength;
    while (this.bytes > limit) this.bytes -= this.frames.shift().byteLength;
  }

  file(hello, scene) {
    const text = new TextEncoder().encode(JSON.stringify({hello, scene}));
    const parts = [new TextEncoder().encode('TSR1'), new Uint32Array([text.length]), text];
    for (const frame of this.frames) parts.push(new Uint32Array([frame.byteLength]), frame);
    return new Blob(parts, {type: 'application/octet-stream'});
  }

  // @return {hello, scene} of the file. @throws Error where it is none.
  open(buffer) {
    const view = new DataView(buffer), size = buffer.byteLength;
    if (size < 8 || view.getUint32(0, false) !== 0x54535231) throw new Error('this is no saved flight');
    const texts = view.getUint32(4, true);
    if (8 + texts > size) throw new Error('the saved flight is cut off');
    const described = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, texts)));
    this.clear();
    for (let at = 8 + texts; at + 4 <= size;) {
      const bytes = view.getUint32(at, true);
      if (at + 4 + bytes > size) break;  // what was cut off is left out
      this.frames.push(buffer.slice(at + 4, at + 4 + bytes));
      at += 4 + bytes;
    }
    this.opened = true;
    return described;
  }
}
