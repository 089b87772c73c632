// Turntables turn under the pointer: the width of the picture is once around.

class Turntable {
  /** Shows frames in a picture; `told` hears of each frame that is shown. */
  constructor(stage, picture, told = () => {}) {
    Object.assign(this, { stage, picture, told, addresses: [], frames: [], at: 0, wanted: 0, from: null });
    stage.addEventListener("pointerenter", e => e.pointerType === "mouse" && !this.dragOnly && this.grab(e));
    stage.addEventListener("pointerdown", e => (e.pointerType !== "mouse" || this.dragOnly) && this.grab(e));
    stage.addEventListener("pointermove", e => this.turn(e));
    for (const end of ["pointerleave", "pointercancel"]) stage.addEventListener(end, () => this.release());
    stage.addEventListener("pointerup", () => this.dragOnly && this.release());
  }

  /** The frames' addresses; fewer than two do not turn. */
  set(addresses) {
    this.addresses = addresses;
    this.frames = [];
    this.at = this.wanted = 0;
    this.from = null;
  }

  get turns() { return this.addresses.length > 1; }

  grab(event) {
    if (!this.turns) return;
    this.from = { x: event.clientX, frame: this.at, width: this.stage.clientWidth || 1 };
    this.load();
  }

  turn(event) {
    if (!this.from) return;
    const count = this.addresses.length;
    const steps = Math.round(((event.clientX - this.from.x) / this.from.width) * count);
    this.moved = this.moved || steps !== 0;
    this.show((((this.from.frame + steps) % count) + count) % count);
  }

  release() {
    if (!this.from) return;
    this.from = null;
    if (this.keeps) return;
    this.show(0);
    // A wall of turntables would fill the memory.
    this.frames = [];
  }

  /** Fetches all frames, so that turning does not wait. */
  load() {
    this.addresses.forEach((address, index) => {
      if (this.frames[index]) return;
      const frame = new Image();
      frame.decoding = "async";
      frame.onload = () => this.frames[index] === frame && this.wanted === index && this.show(index);
      frame.src = address;
      this.frames[index] = frame;
    });
  }

  /** Shows a frame, or the nearest one that is there until it is. */
  show(index) {
    this.wanted = index;
    const ready = k => k === 0 || (this.frames[k]?.complete && this.frames[k].naturalWidth > 0);
    const count = this.addresses.length;
    for (let step = 0; step <= count / 2; step += 1) {
      const near = [(index + step) % count, (index - step + count) % count].find(ready);
      if (near === undefined) continue;
      if (near !== this.at) this.picture.src = this.addresses[near];
      this.at = near;
      break;
    }
    this.told(index);
  }
}
