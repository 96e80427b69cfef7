// An engine as a process in Node, binary protocol: `serve` reads solids and pairs and writes what `answer` says. No packages.
import { readFileSync, readSync, writeSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

export const SEPARATED = 0, OVERLAPPING = 1, UNDECIDED = 2, FAILED = 3, UNSUPPORTED = 4;
export const OVERLAP = 0, DISTANCE = 1, MANIFOLD = 2;
const HEAD = 40, PAIR = 200, GEOMETRY = 88, POINT = 64, SOLID = 192, AT_ONCE = 64;

/** An npm package from the working folder, NODE_PATH or beside this file: { module, version }; ends the program where it is none. */
export async function load(name) {
  const folders = [process.cwd(), ...(process.env.NODE_PATH ?? '').split(':').filter(Boolean).map((f) => join(f, '..')), import.meta.dirname];
  for (const folder of folders) {
    try {
      const require = createRequire(join(folder, 'x.js'));
      const entry = require.resolve(name), inside = `node_modules/${name}/`;
      const version = require(entry.slice(0, entry.lastIndexOf(inside)) + inside + 'package.json').version;
      return { module: await import(pathToFileURL(entry)), version };
    } catch (error) {
      if (!['MODULE_NOT_FOUND', 'ERR_PACKAGE_PATH_NOT_EXPORTED'].includes(error.code)) throw error;
    }
  }
  console.error(`npm package '${name}' is not installed: npm install ${name}`);
  process.exit(3);
}

function read(bytes) {
  const buffer = Buffer.alloc(bytes);
  for (let have = 0; have < bytes;) {
    const more = readSync(0, buffer, have, bytes - have, null);
    if (more === 0) process.exit(0); // the pairs' end
    have += more;
  }
  return buffer;
}
function write(buffer) {
  for (let done = 0; done < buffer.length;) done += writeSync(1, buffer, done);
}
const doubles = (buffer, at, count) => Array.from({ length: count }, (_, i) => buffer.readDoubleLE(at + 8 * i));
const poseAt = (buffer, at) => ({ R: doubles(buffer, at, 9), p: doubles(buffer, at + 72, 3) }); // R by columns

/** Half sides of corners that are a box about their origin, else null. */
export function halfSides(corners) {
  const h = [0, 1, 2].map((axis) => corners[21 + axis]);
  return corners.every((x, i) => Math.abs(x) === h[i % 3]) ? h : null;
}
/** x, y, z, w of a rotation by columns (Shepperd). */
export function quaternion(R) {
  const [xx, yx, zx, xy, yy, zy, xz, yz, zz] = R;
  const t = [xx - yy - zz, yy - xx - zz, zz - xx - yy, xx + yy + zz];
  const k = t.indexOf(Math.max(...t));
  const q = [[t[0] + 1, yx + xy, zx + xz, zy - yz], [yx + xy, t[1] + 1, zy + yz, xz - zx],
    [zx + xz, zy + yz, t[2] + 1, yx - xy], [zy - yz, xz - zx, yx - xy, t[3] + 1]][k];
  const length = Math.hypot(...q);
  return q.map((x) => x / length);
}

function put(out, at, answer, query, maxPoints) {
  out.writeUInt32LE(answer.status, at);
  if (query === OVERLAP) return at + 4;
  const vector = (v, to) => (v ?? [NaN, NaN, NaN]).forEach((x, i) => out.writeDoubleLE(x, to + 8 * i));
  out.writeDoubleLE(answer.separation ?? Infinity, at + 4);
  [answer.n, answer.pA, answer.pB].forEach((v, i) => vector(v, at + 12 + 24 * i));
  const points = query === MANIFOLD && answer.points ? answer.points.slice(0, maxPoints) : [];
  out.writeInt32LE(points.length, at + 84);
  points.forEach((point, i) => {
    const to = at + 92 + POINT * i;
    vector(point.pA, to), vector(point.pB, to + 24), out.writeDoubleLE(point.separation, to + 48);
  });
  return at + 4 + GEOMETRY + (query === MANIFOLD ? maxPoints * POINT : 0);
}

/** What the engine says about the first pair of a pair file, without anything of touchstone's. */
function askAlone(path, build, answer, queries) {
  let pair, solids, A, B;
  try {
    pair = JSON.parse(readFileSync(path, 'utf8'))[0];
    solids = pair.shapes.map(({ size, vertices }) => vertices?.flat() ??
      Array.from({ length: 24 }, (_, i) => ((Math.floor(i / 3) >> (2 - (i % 3))) & 1) * size[i % 3] - size[i % 3] / 2));
    [A, B] = pair.poses.map(({ matrix: m }) => ({ R: [0, 1, 2].flatMap((k) => [0, 1, 2].map((row) => m[row][k])), p: [0, 1, 2].map((row) => m[row][3]) }));
  } catch (error) {
    console.error(`${path}: its first pair is none as compare_backends writes them: boxes or vertices, poses as matrices [m] (${error.message})`);
    process.exit(1);
  }
  build(solids);
  queries.forEach((name, query) => {
    const question = { query, maxPoints: 8, maxSeparation: query === MANIFOLD ? 0 : Infinity, maxPointSeparation: 1e-3 };
    console.error(pair.id, name, JSON.stringify(answer(question, 0, 1, A, B)));
  });
}

/** greeting: name, description, distance ...; build(corners of each solid, 24 numbers); answer(question, a, b, X_WA, X_WB).
 * With --pair FILE: prints its answers to one pair instead. */
export function serve(greeting, build, answer) {
  if (process.argv[2] === '--pair') {
    console.error(greeting.description);
    askAlone(process.argv[3], build, answer, ['overlap', 'distance', ...(greeting.manifold ? ['manifold'] : [])]);
    return;
  }
  write(Buffer.from(JSON.stringify({ touchstone: 1, format: 'binary', ...greeting }) + '\n'));
  for (;;) {
    const head = read(HEAD);
    const [kind, count, batch, query, maxPoints] = [0, 4, 8, 12, 16].map((at) => head.readUInt32LE(at));
    if (kind === 1) {
      build(Array.from({ length: count }, () => doubles(read(SOLID), 0, 24)));
      continue;
    }
    const question = { query, maxPoints, maxSeparation: head.readDoubleLE(24), maxPointSeparation: head.readDoubleLE(32) };
    const pairs = read(count * PAIR);
    const each = 8 + (query === OVERLAP ? 0 : GEOMETRY) + (query === MANIFOLD ? maxPoints * POINT : 0);
    const start = Buffer.alloc(8);
    start.writeUInt32LE(batch, 0), start.writeUInt32LE(count, 4);
    write(start);
    for (let first = 0; first < count; first += AT_ONCE) { // early bytes show that it lives
      const last = Math.min(count, first + AT_ONCE), out = Buffer.alloc(each * (last - first));
      for (let i = first, at = 0; i < last; ++i) {
        const from = i * PAIR, a = pairs.readUInt32LE(from), b = pairs.readUInt32LE(from + 4);
        out.writeUInt32LE(i, at);
        at = put(out, at + 4, answer(question, a, b, poseAt(pairs, from + 8), poseAt(pairs, from + 104)), query, maxPoints);
      }
      write(out);
    }
  }
}
