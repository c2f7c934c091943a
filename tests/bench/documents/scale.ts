/** Tables of docs/scale.md: the cost of a volume that is a thousand times larger than measured ones. */
import { exponentOf } from "../growth/exponents.ts";
import { readResults } from "../harness/table.ts";
import { type Measure, measures, Series } from "./growth.ts";
import { amount, markdown } from "./markdown.ts";

const voxels = [10240, 7680, 1536] as const;
const allVoxels = voxels.reduce((product, n) => product * n, 1);
const voxelBytes = 8;

/** The assumptions of the plan. */
const given = {
  viewers: 10_000,
  minutes: 10,
  viewsEach: 10,
  distinctViews: 100,
  places: 50,
  deliveryPerGB: 0.04,
  storagePerGBMonth: 0.023,
  diskGBs: 1,
  serverCores: 16,
  serverGbit: 10,
  coreHour: 0.05,
  pixels: [1024, 768],
  /** The sample budget of a desktop computer: web/stream/device.ts. */
  sampleBudget: 24e6,
} as const;

/**
 * Limits of the format (shared/core/store/FORMAT.md), and of a response of the server
 * (server/HTTP.md).
 */
const most = {
  pages: 3500,
  axis: 2 ** 20,
  pageLog2: 5,
  answerMiB: 64,
  answerChunks: 65_536,
  answerPagesMiB: 256,
};

const kinds = ["turbulence", "fractal"] as const;

/** Blocks and directory pages of all levels (FORMAT.md: levels, and the section PAGE). */
function directoryOf(pageLog2: number): { blocks: number; pages: number } {
  let cells = voxels.map((n) => n - 1);
  let [blocks, pages] = [0, 0];
  const product = (counts: number[]) => counts.reduce((all, count) => all * count, 1);
  for (;;) {
    const ofLevel = cells.map((n) => Math.ceil(n / 64));
    blocks += product(ofLevel);
    pages += product(ofLevel.map((n) => Math.ceil(n / 2 ** pageLog2)));
    if (cells.every((n) => n <= 16)) return { blocks, pages };
    cells = cells.map((n) => Math.ceil(n / 2));
  }
}

/** Pages of the smallest boxes that the format allows for this volume. */
function pagesNeeded(): number {
  for (let log2 = 2; log2 < most.pageLog2; ++log2) {
    const { pages } = directoryOf(log2);
    if (pages <= most.pages) return pages;
  }
  return directoryOf(most.pageLog2).pages;
}

/**
 * The finest level of the picture: the coarsest level whose cells at the front are no larger than a
 * pixel.
 */
function finestLevel(): number {
  const longest = Math.max(...voxels);
  const nearest = 1.5 * longest - voxels[1] / 2;
  const visible = 2 * nearest * Math.tan(Math.PI / 8);
  return Math.floor(Math.log2(visible / given.pixels[1]));
}

interface Plan {
  coreHours: number;
  storeBytes: number;
  directoryBytes: number;
  isovalueChunks: number;
  isovalueBytes: number;
  firstBytes: number;
  /**
   * The bytes of a complete picture: those that it needs, and those that the sample budget allows.
   */
  neededBytes: number;
  neededSamples: number;
  viewBytes: number;
}

/** The measured figures of a kind of volumes, continued to this volume. */
function planOf(kind: string): Plan {
  const series = new Series(kind);
  const measured = 1e6 * series.last({ name: "voxels", unit: "million" });
  const times = allVoxels / measured;
  const surface = series.lastExponent(measures.bytes);
  // The finest level of the picture, relative to that of the small picture of the largest volume.
  const level = series.last({ name: "finest level, 128 × 96", unit: "" });
  const cells = allVoxels / 8 ** finestLevel() / (measured / 8 ** level);
  const neededBytes = 1e3 * series.last(measures.small) * cells ** surface;
  const samplesPerByte = (1e6 * series.last(measures.cells)) / (1e3 * series.last(measures.bytes));
  const firstSurfaces = series.points(measures.first).map(({ figure }) => figure);
  const neededSamples = neededBytes * samplesPerByte;
  return {
    coreHours: (series.last(measures.build) * times) / 3600,
    storeBytes: 1e6 * series.last(measures.store) * times,
    directoryBytes: 1e3 * series.last(measures.pages) * times,
    isovalueChunks: series.last(measures.chunks) * times ** series.lastExponent(measures.chunks),
    isovalueBytes: 1e3 * series.last(measures.bytes) * times ** surface,
    firstBytes: 1e3 * Math.max(...firstSurfaces) + 12 * pagesNeeded(),
    neededBytes,
    neededSamples,
    viewBytes: neededBytes * Math.min(1, given.sampleBudget / neededSamples),
  };
}

const megabytes = (bytes: number) => amount(bytes / 1e6, "MB");
const gigabytes = (bytes: number) => amount(bytes / 1e9, "GB");

/** A table with a column for each kind of volumes. */
function byKind(rows: [string, (plan: Plan) => string, string][]): string {
  const plans = kinds.map(planOf);
  const heading = ["", ...kinds.map((kind) => `as the ${kind}`), "how"];
  const lines = rows.map(([name, of, how]) => [name, ...plans.map(of), how]);
  return markdown([heading, heading.map(() => "---"), ...lines]);
}

/** The table of the cost of one such volume. */
export function volumePlan(): string {
  const proportional = "in proportion to the voxels";
  return byKind([
    ["voxels", () => amount(allVoxels / 1e9, "billion"), voxels.join(" × ")],
    ["the file", () => gigabytes(allVoxels * voxelBytes), `${voxelBytes} bytes a voxel`],
    ["build, core hours", (plan) => amount(plan.coreHours), proportional],
    [
      `build, hours on ${given.serverCores} cores`,
      (plan) => amount(plan.coreHours / given.serverCores),
      "if the disk keeps up",
    ],
    [
      "reading the file twice, hours",
      () => amount((2 * allVoxels * voxelBytes) / (1e9 * given.diskGBs) / 3600),
      `${given.diskGBs} GB/s; for the range of values, then for the voxels`,
    ],
    ["store", (plan) => gigabytes(plan.storeBytes), proportional],
    ["directory pages", (plan) => megabytes(plan.directoryBytes), proportional],
    [
      "an isovalue at level 0",
      (plan) => gigabytes(plan.isovalueBytes),
      "with the exponent of the last step",
    ],
    [
      "until the first surface",
      (plan) => megabytes(plan.firstBytes),
      "the most measured, and 12 bytes for each directory page",
    ],
    [
      `complete picture, ${given.pixels.join(" × ")}`,
      (plan) => megabytes(plan.neededBytes),
      `level ${finestLevel()} and coarser ones`,
    ],
    [
      "its samples",
      (plan) => amount(plan.neededSamples / 1e6, "million"),
      "as many per byte as level 0 of the isovalue",
    ],
    [
      "what a desktop computer fetches of it",
      (plan) => megabytes(plan.viewBytes),
      `at most ${given.sampleBudget / 1e6} million samples`,
    ],
  ]);
}

/**
 * Checks the calculation with known results. It predicts the largest measured volume from the
 * smaller ones, and its usual picture from the small one. Values are calculated ÷ measured.
 */
export function checks(): string {
  const proportional = (measure: Measure) => (series: Series) => {
    const [before, last] = series.lastTwo(measure);
    return (before.figure * last.voxels) / before.voxels / last.figure;
  };
  const isovalue = (series: Series) => {
    const [before, last] = series.lastTwo(measures.bytes);
    const exponent = exponentOf(series.points(measures.bytes).slice(-3, -1));
    return (before.figure * (last.voxels / before.voxels) ** exponent) / last.figure;
  };
  const picture = (series: Series) => {
    const level = (size: string) => series.last({ name: `finest level, ${size}`, unit: "" });
    const cells = 8 ** (level("128 × 96") - level("1024 × 768"));
    const bytes = series.last(measures.small) * cells ** series.lastExponent(measures.bytes);
    return bytes / series.last(measures.large);
  };
  const rows: [string, (series: Series) => number][] = [
    ["build, from the last but one size", proportional(measures.build)],
    ["store, likewise", proportional(measures.store)],
    ["directory pages, likewise", proportional(measures.pages)],
    ["an isovalue at level 0, likewise", isovalue],
    ["complete picture, 1024 × 768, from 128 × 96", picture],
  ];
  const heading = ["calculated ÷ measured", ...kinds];
  const all = kinds.map((kind) => new Series(kind));
  const lines = rows.map(([name, of]) => [name, ...all.map((series) => of(series).toFixed(2))]);
  return markdown([heading, heading.map(() => "---"), ...lines]);
}

/** The processor seconds that the server takes for a byte, with TLS. */
function secondsPerByte(): number {
  const bytes = 20378;
  const what = `chunk of ${bytes} bytes, TLS, isosplat`;
  const row = readResults("server").find(
    (r) => r.case === what && r.measure === "processor time of a request",
  );
  if (!row) throw new Error(`server.csv: expected the processor time of a request of "${what}"`);
  return (row.median * 1e-6) / bytes;
}

/** The table of the cost of 10,000 viewers, with and without a CDN. */
export function viewersPlan(): string {
  const seconds = 60 * given.minutes;
  const perByte = secondsPerByte();
  const delivered = ({ viewBytes }: Plan) => given.viewers * given.viewsEach * viewBytes;
  const missed = (plan: Plan) =>
    Math.min(delivered(plan), given.places * given.distinctViews * plan.viewBytes);
  const gbit = (bytes: number) => (8 * bytes) / seconds / 1e9;
  const cores = (bytes: number) => (bytes * perByte) / seconds;
  const servers = (bytes: number) =>
    Math.max(
      Math.ceil(gbit(bytes) / given.serverGbit),
      Math.ceil(cores(bytes) / given.serverCores),
    );
  const month = ({ storeBytes }: Plan) => (storeBytes / 1e9) * given.storagePerGBMonth;
  const dollars = (value: number) => `$ ${amount(value)}`;
  return byKind([
    ["delivered", (plan) => gigabytes(delivered(plan)), "viewers × views × bytes of a view"],
    ["rate", (plan) => amount(gbit(delivered(plan)), "Gbit/s"), "delivered ÷ time"],
    [
      "without a CDN: cores",
      (plan) => amount(cores(delivered(plan))),
      "processor time of a byte with TLS × rate",
    ],
    [
      "without a CDN: servers",
      (plan) => String(servers(delivered(plan))),
      "by the cores or by the network, whichever is more",
    ],
    [
      "with a CDN: fetched from the origin",
      (plan) => gigabytes(missed(plan)),
      "places × different views × bytes of a view",
    ],
    [
      "with a CDN: hits, % of the bytes",
      (plan) => amount(100 * (1 - missed(plan) / delivered(plan))),
      "",
    ],
    ["with a CDN: origin servers", (plan) => String(servers(missed(plan))), "as above"],
    [
      "cost of delivery",
      (plan) => dollars((delivered(plan) / 1e9) * given.deliveryPerGB),
      "delivered × price",
    ],
    ["cost of the store, a month", (plan) => dollars(month(plan)), "store × price"],
    ["cost of the build", (plan) => dollars(plan.coreHours * given.coreHour), "core hours × price"],
  ]);
}

/** The assumptions of the plan, as a list in Markdown. */
export function assumptions(): string {
  return [
    `${given.viewers.toLocaleString("en")} viewers within ${given.minutes} minutes, evenly spread`,
    `each looks at ${given.viewsEach} views, and none of them shares a byte with another of the same viewer`,
    `all together look at ${given.distinctViews} different views`,
    `a CDN of ${given.places} places, each of which fetches each view from the origin once`,
    `$ ${given.deliveryPerGB} for a GB delivered, $ ${given.storagePerGBMonth} for a GB stored a month, $ ${given.coreHour} for a core hour: of the order of list prices; put in your own`,
    `a disk that reads ${given.diskGBs} GB/s`,
    `a server has ${given.serverCores} cores and ${given.serverGbit} Gbit/s`,
  ]
    .map((line) => `- ${line}`)
    .join("\n");
}

/** Each limit, and the share of it that this volume needs, the largest share first. */
export function limits(): string {
  const plans = kinds.map(planOf);
  const least = readResults("growth").find(({ measure }) => measure === "least memory of a build");
  if (!least) throw new Error("growth.csv: expected the least memory of a build");
  const largest = (of: (plan: Plan) => number) => Math.max(...plans.map(of));
  const rows = [
    {
      what: "an isovalue at level 0 in one answer of the server",
      needs: largest((plan) => plan.isovalueBytes) / 2 ** 20,
      limit: most.answerMiB,
      unit: "MiB",
      done: "413; the page asks for the chunks of its view in batches, programs for blocks or a coarser level",
    },
    {
      what: "its chunks in one answer",
      needs: largest((plan) => plan.isovalueChunks),
      limit: most.answerChunks,
      unit: "",
      done: "as above",
    },
    {
      what: "directory pages of all isovalues",
      needs: largest((plan) => plan.directoryBytes) / 2 ** 20,
      limit: most.answerPagesMiB,
      unit: "MiB",
      done: "a reader needs only the pages of its level, isovalue and view",
    },
    {
      what: "samples of a complete picture",
      needs: largest((plan) => plan.neededSamples) / 1e6,
      limit: given.sampleBudget / 1e6,
      unit: "million",
      done: "the client keeps what exceeds the budget coarser (state *limited*); with a GPU, occluded chunks are not fetched",
    },
    {
      what: "memory of a build",
      needs: least.median / 1024,
      limit: 1,
      unit: "GiB",
      done: "`isosplat build` says before it starts what it needs: `--memory`",
    },
    {
      what: "directory pages",
      needs: pagesNeeded(),
      limit: most.pages,
      unit: "",
      done: "pages describe larger boxes, up to 32³ blocks",
    },
    {
      what: "voxels along an axis",
      needs: Math.max(...voxels),
      limit: most.axis,
      unit: "",
      done: "none needed",
    },
  ];
  rows.sort((a, b) => b.needs / b.limit - a.needs / a.limit);
  const heading = ["limit", "needed", "limit or default", "needed ÷ limit", "what is done"];
  return markdown([
    heading,
    heading.map(() => "---"),
    ...rows.map(({ what, needs, limit, unit, done }) => [
      what,
      amount(needs, unit),
      amount(limit, unit),
      amount(needs / limit),
      done,
    ]),
  ]);
}
