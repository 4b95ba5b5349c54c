// Reads what tools/page/packing.cpp packs: JSON in front, then numbers of 16 bits, column by column,
// each the change to the one before.

/** The JSON, with `rows` (Float32Array each) in every one of its trials. */
export function unpack(bytes) {
  const head = new DataView(bytes.buffer, bytes.byteOffset).getUint32(0, true);
  const text = new TextDecoder().decode(bytes.subarray(4, 4 + head));
  const scene = JSON.parse(text);
  const words = new Int16Array(bytes.slice(4 + head).buffer);
  let at = 0;
  for (const trial of scene.trials) {
    trial.rows = Array.from({ length: trial.count }, () => new Float32Array(scene.columns.length));
    for (let c = 0; c < scene.columns.length; ++c)
      for (let k = 0, sum = 0; k < trial.count; ++k) {
        sum = (sum + words[at++]) << 16 >> 16;  // wraps as the writer's does
        trial.rows[k][c] = trial.low[c] + (sum + 32768) * trial.step[c];
      }
  }
  return scene;
}
