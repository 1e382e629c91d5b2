// tests/zarrita/check.mjs: reads every level of the stores that bricking_store_test wrote, with zarrita, and compares
// each value with the raw copy beside it (float64, [z][y][x]). Usage: node check.mjs FOLDER; zarrita is found beside
// this file, so it runs as a copy in the build folder.
import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import * as zarr from "zarrita";

/// A read-only Zarr store over a folder; zarrita asks for whole files and for ranges of shards.
class FolderStore {
  constructor(root) {
    this.root = root;
  }
  async get(key) {
    try {
      return new Uint8Array(readFileSync(join(this.root, key)));
    } catch (error) {
      if (error.code === "ENOENT") return undefined; // an absent chunk is legal: it is all fill
      throw error;
    }
  }
  async getRange(key, range) {
    const bytes = await this.get(key);
    if (bytes === undefined) return undefined;
    if ("suffixLength" in range) return bytes.slice(bytes.length - range.suffixLength);
    return bytes.slice(range.offset, range.offset + range.length);
  }
}

let wrong = 0;
let compared = 0;
const fail = (text) => {
  console.error(text);
  wrong += 1;
};

const folder = process.argv[2];
for (const type of readdirSync(folder).sort()) {
  const group = await zarr.open(new FolderStore(join(folder, type, "v.zarr")), { kind: "group" });
  const datasets = group.attrs.ome.multiscales[0].datasets;
  if (datasets.length !== 6) fail(`${type}: expected 6 levels, found ${datasets.length}`);
  for (const { path, coordinateTransformations } of datasets) {
    const array = await zarr.open(group.resolve(path), { kind: "array" });
    if (array.dtype !== type) fail(`${type} level ${path}: found type ${array.dtype}`);
    const scale = coordinateTransformations[0].scale;
    const base = datasets[0].coordinateTransformations[0].scale;
    if (scale.some((s, i) => s !== base[i] * 2 ** Number(path))) fail(`${type} level ${path}: scale ${scale}`);
    const { data } = await zarr.get(array);
    const raw = readFileSync(join(folder, type, `${path}.f64`));
    const expected = new Float64Array(raw.buffer.slice(raw.byteOffset, raw.byteOffset + raw.byteLength));
    if (data.length !== expected.length) fail(`${type} level ${path}: ${data.length} values, not ${expected.length}`);
    let differences = 0;
    for (let i = 0; i < expected.length; ++i) if (!Object.is(data[i] + 0, expected[i] + 0)) differences += 1;
    if (differences > 0) fail(`${type} level ${path}: ${differences} of ${expected.length} values differ`);
    compared += expected.length;
  }
  const cells = await zarr.open(group.resolve("stats/cell_min"), { kind: "array" });
  await zarr.get(cells); // the statistics are plain Zarr too
}
if (compared === 0) fail(`${folder}: no store to compare`);
console.log(`zarrita compared ${compared} values, ${wrong} faults`);
process.exit(wrong === 0 ? 0 : 1);
