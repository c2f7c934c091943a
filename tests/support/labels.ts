import { Chance } from "./chance.ts";

type Triple = readonly [number, number, number];

/** A volume of labels, x fastest. */
export class LabelVolume {
  readonly labels: Uint16Array;

  constructor(readonly size: Triple) {
    this.labels = new Uint16Array(size[0] * size[1] * size[2]);
  }

  /** Sets the voxels within an ellipsoid, including those with other labels. */
  addEllipsoid(label: number, centre: Triple, radii: Triple): void {
    this.#fill(label, centre, radii, (x, y, z) => x * x + y * y + z * z <= 1);
  }

  /** A thin shell: half of an ellipsoid's surface, `thickness` voxels thick. */
  addSheet(label: number, centre: Triple, radii: Triple, thickness: number): void {
    const inner = 1 - thickness / Math.min(...radii);
    this.#fill(label, centre, radii, (x, y, z) => {
      const r = Math.hypot(x, y, z);
      return x > 0 && r <= 1 && r > inner;
    });
  }

  /** A tube along an arc around the z axis, which rises by `rise` voxels. */
  addTube(label: number, centre: Triple, arc: Triple, angles: readonly [number, number]): void {
    const [across, along, radius] = arc;
    const [from, to] = angles;
    const steps = Math.ceil((Math.abs(to - from) * Math.max(across, along)) / (radius / 2));
    for (let i = 0; i <= steps; ++i) {
      const angle = from + ((to - from) * i) / steps;
      const at: Triple = [
        centre[0] + across * Math.cos(angle),
        centre[1] + along * Math.sin(angle),
        centre[2] - (30 * i) / steps,
      ];
      this.addEllipsoid(label, at, [radius, radius, radius]);
    }
  }

  #fill(
    label: number,
    centre: Triple,
    radii: Triple,
    isInside: (x: number, y: number, z: number) => boolean,
  ): void {
    const low = centre.map((c, i) => Math.max(0, Math.ceil(c - (radii[i] ?? 0))));
    const high = centre.map((c, i) =>
      Math.min((this.size[i] ?? 1) - 1, Math.floor(c + (radii[i] ?? 0))),
    );
    const [x0 = 0, y0 = 0, z0 = 0] = low;
    const [x1 = 0, y1 = 0, z1 = 0] = high;
    for (let z = z0; z <= z1; ++z) {
      for (let y = y0; y <= y1; ++y) {
        const row = (z * this.size[1] + y) * this.size[0];
        for (let x = x0; x <= x1; ++x) {
          const u = (x - centre[0]) / radii[0];
          const v = (y - centre[1]) / radii[1];
          const w = (z - centre[2]) / radii[2];
          if (isInside(u, v, w)) this.labels[row + x] = label;
        }
      }
    }
  }

  /** The volume as an NRRD file, with voxels of 1.5 mm. */
  nrrd(): Buffer {
    const header =
      "NRRD0004\ntype: uint16\ndimension: 3\nspace: left-posterior-superior\n" +
      `sizes: ${this.size.join(" ")}\nspace directions: (1.5,0,0) (0,1.5,0) (0,0,1.5)\n` +
      "space origin: (0,0,0)\nencoding: raw\nendian: little\n\n";
    return Buffer.concat([Buffer.from(header), Buffer.from(this.labels.buffer)]);
  }
}

/**
 * 105 labels of 317 × 317 × 835 voxels, like the organs of a person: vertebrae that touch, ribs and
 * vessels as tubes, organs that touch, parts nested in them, and sheets of one or two voxels.
 */
export function organs(): LabelVolume {
  const volume = new LabelVolume([317, 317, 835]);
  const chance = new Chance(5);
  const between = (low: number, high: number) => low + (high - low) * chance.next();
  let label = 0;
  const organs: { centre: Triple; radii: Triple }[] = [];
  for (let i = 0; i < 16; ++i) {
    const centre: Triple = [between(80, 237), between(90, 190), 120 + 38 * i];
    const radii: Triple = [between(22, 52), between(20, 42), between(22, 48)];
    organs.push({ centre, radii });
    volume.addEllipsoid(++label, centre, radii);
  }
  for (const { centre, radii } of organs) {
    const inner = radii.map((r) => r * between(0.25, 0.5)) as unknown as Triple;
    volume.addEllipsoid(++label, centre, inner);
  }
  for (let i = 0; i < 24; ++i) volume.addEllipsoid(++label, [158, 235, 100 + 28 * i], [20, 16, 14]);
  for (let i = 0; i < 24; ++i) {
    const side = i % 2 === 0 ? [0.4 * Math.PI, -0.4 * Math.PI] : [0.6 * Math.PI, 1.4 * Math.PI];
    const centre: Triple = [158, 150, 400 + 28 * Math.floor(i / 2)];
    volume.addTube(++label, centre, [128, 100, between(3, 5)], side as [number, number]);
  }
  for (let i = 0; i < 20; ++i) {
    const centre: Triple = [between(120, 200), between(120, 200), between(120, 760)];
    volume.addTube(++label, centre, [between(30, 70), between(20, 60), between(1, 3.5)], [0, 4]);
  }
  while (label < 105) {
    const centre: Triple = [between(100, 200), between(110, 200), between(150, 700)];
    volume.addSheet(
      ++label,
      centre,
      [between(30, 70), between(30, 60), 50],
      label % 2 === 0 ? 1.2 : 2,
    );
  }
  return volume;
}

/**
 * 105 labels that fill 29 % of 317 × 317 × 835 voxels, like a segmentation of a whole body. 52
 * parts of a torso touch each other, with 12 gaps between them. Vertebrae, ribs, vessels and sheets
 * are inside of these parts.
 */
export function body(): LabelVolume {
  const volume = new LabelVolume([317, 317, 835]);
  const chance = new Chance(11);
  const between = (low: number, high: number) => low + (high - low) * chance.next();
  const centre: Triple = [158, 155, 417];
  const torso: Triple = [138, 112, 390];
  const parts = Array.from({ length: 64 }, (_, i) => ({
    label: i < 52 ? i + 1 : 0,
    at: [between(40, 276), between(70, 240), between(40, 795)] as Triple,
    flatness: between(0.6, 1.6),
  }));
  const partsX = Float64Array.from(parts, ({ at }) => at[0]);
  const across = new Float64Array(parts.length);
  const waves = (count: number, height: number, length: number) =>
    Float64Array.from({ length: count }, (_, i) => height * Math.sin(i / length));
  const [waveX, waveY, waveZ] = [waves(317, 7, 21), waves(317, 6, 17), waves(835, 8, 29)];
  for (let z = 0; z < 835; ++z) {
    for (let y = 0; y < 317; ++y) {
      const rest = 1 - ((z - centre[2]) / torso[2]) ** 4 - ((y - centre[1]) / torso[1]) ** 2;
      if (rest <= 0) continue;
      const reach = Math.floor(torso[0] * Math.sqrt(rest));
      const shifted = (waveY[y] ?? 0) + (waveZ[z] ?? 0);
      for (const [i, { at, flatness }] of parts.entries()) {
        const dy = y - at[1] + (waveZ[z] ?? 0);
        const dz = (z - at[2] + (waveY[y] ?? 0)) * flatness;
        across[i] = dy * dy + dz * dz;
      }
      const row = (z * 317 + y) * 317;
      for (let x = centre[0] - reach; x <= centre[0] + reach; ++x) {
        const shiftedX = x + shifted + (waveX[x] ?? 0);
        let nearest = 0;
        let least = Number.POSITIVE_INFINITY;
        for (let i = 0; i < across.length; ++i) {
          const dx = shiftedX - (partsX[i] ?? 0);
          const distance = dx * dx + (across[i] ?? 0);
          if (distance < least) {
            least = distance;
            nearest = i;
          }
        }
        volume.labels[row + x] = parts[nearest]?.label ?? 0;
      }
    }
  }
  let label = 52;
  for (let i = 0; i < 22; ++i) volume.addEllipsoid(++label, [158, 215, 90 + 28 * i], [20, 16, 14]);
  for (let i = 0; i < 22; ++i) {
    const side = i % 2 === 0 ? [0.4 * Math.PI, -0.4 * Math.PI] : [0.6 * Math.PI, 1.4 * Math.PI];
    const at: Triple = [158, 150, 400 + 28 * Math.floor(i / 2)];
    volume.addTube(++label, at, [118, 84, between(3, 5)], side as [number, number]);
  }
  for (let i = 0; i < 6; ++i) {
    const at: Triple = [between(120, 200), between(120, 190), between(150, 700)];
    volume.addTube(++label, at, [between(30, 70), between(20, 60), 1.5 + i / 2], [0, 4]);
  }
  while (label < 105) {
    const at: Triple = [between(100, 200), between(110, 200), between(150, 700)];
    volume.addSheet(++label, at, [between(30, 70), between(30, 60), 50], 1 + (label % 3) / 2);
  }
  return volume;
}

/** Many small labels in a lattice, some of which touch. */
export function manyLabels(count: number): LabelVolume {
  const edge = Math.ceil(Math.cbrt(count));
  const volume = new LabelVolume([edge * 20, edge * 20, edge * 20]);
  for (let i = 0; i < count; ++i) {
    const centre = [i % edge, Math.floor(i / edge) % edge, Math.floor(i / edge ** 2)].map(
      (index) => 20 * index + 9.5,
    ) as unknown as Triple;
    volume.addEllipsoid(i + 1, centre, [9 + (i % 3), 8, 9]);
  }
  return volume;
}
