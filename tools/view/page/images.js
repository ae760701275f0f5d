// Both cameras' images with their tracks.

const kUses = [['new', '--s1'], ['waiting', '--warn'], ['used', '--good'], ['rejected', '--bad']];
const kTrackFloats = 4;  // x, y, age, use

export class Images {
  constructor(left, right, legend) {
    this.canvases = [left, right];
    this.busy = [false, false];
    this.shown = 0;
    this.recolour();
    legend.innerHTML = kUses.map(([name, colour]) => `<i style="--c:var(${colour})"></i>${name}`)
        .join('');
  }

  recolour() {
    const style = getComputedStyle(document.documentElement);
    this.colours = kUses.map(([, colour]) => style.getPropertyValue(colour).trim());
  }

  setCameras(count) {
    this.canvases[0].parentElement.classList.toggle('one', count === 1);
    for (const canvas of this.canvases) canvas.getContext('2d').clearRect(0, 0, 1e4, 1e4);
  }

  // A picture that is still decoded when the next comes is shown, the next is not.
  async show(message, array) {
    const camera = message.camera;
    if (this.busy[camera]) return;
    this.busy[camera] = true;
    try {
      const tracksBytes = 4 * kTrackFloats * message.tracks;
      const tracks = new Float32Array(array, 0, kTrackFloats * message.tracks);
      const jpeg = new Uint8Array(array, tracksBytes, message.jpeg);
      const bitmap = await createImageBitmap(new Blob([jpeg], {type: 'image/jpeg'}));
      this.draw(this.canvases[camera], bitmap, message, tracks);
      bitmap.close();
      this.shown++;
    } finally {
      this.busy[camera] = false;
    }
  }

  draw(canvas, bitmap, message, tracks) {
    if (canvas.width !== bitmap.width || canvas.height !== bitmap.height) {
      canvas.width = bitmap.width;
      canvas.height = bitmap.height;
    }
    const g = canvas.getContext('2d');
    g.drawImage(bitmap, 0, 0);
    const scale = bitmap.width / message.width;
    g.lineWidth = 1.4;
    kUses.forEach((_, use) => {
      g.strokeStyle = this.colours[use];
      g.beginPath();
      for (let i = 0; i < message.tracks; ++i) {
        if (tracks[kTrackFloats * i + 3] !== use) continue;
        const x = (tracks[kTrackFloats * i] + 0.5) * scale;
        const y = (tracks[kTrackFloats * i + 1] + 0.5) * scale;
        g.moveTo(x + 2.4, y);
        g.arc(x, y, 2.4, 0, 7);
      }
      g.stroke();
    });
  }
}
