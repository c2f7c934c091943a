/** Tables of docs/scale.md: the time of a build by several ranks, from its measured parts. */
import { readResults } from "../harness/table.ts";
import { amount, markdown, short } from "./markdown.ts";

/** The volume: 16 bits a voxel. */
const voxels = [10240, 7680, 1536] as const;
const allVoxels = voxels.reduce((product, n) => product * n, 1);
/** Of the measured volume. The sample has about as many slices of any volume. */
const bunnySlices = 361;
const layers = Math.ceil((voxels[2] - 1) / 64);

const given = {
  /** Of a message, between two ranks. */
  networkGBs: 10,
  /** Of the file system, for all ranks together, and for one process. */
  readGBs: 10,
  writeGBs: 2,
} as const;

const ranks = [1, 2, 4, 8, 16, 64, 256, 1024];

/** Seconds, or GB, of the whole volume. */
function total(what: string, measure: string): number {
  const found = readResults("ranks").filter(
    (row) => row.case === what && row.measure === measure,
  )[0];
  if (!found) throw new Error(`ranks.csv: expected "${measure}" of "${what}"`);
  return (found.median * allVoxels) / 1e9;
}

const finest = (measure: string) => total("bunny, level 0", measure);
const coarser = (measure: string) => total("bunny, coarser levels", measure);
const onNetwork = (gigabytes: number) => gigabytes / given.networkGBs;

/** A step of a build: what its ranks do at the same time. */
type Step = Record<string, number>;

const longest = (step: Step) => Math.max(...Object.values(step));

/** The steps of a build by n ranks with one thread each, in seconds. One rank sends no messages. */
function stepsOf(n: number): Step[] {
  const ofRanks = (seconds: number, most = n) => seconds / Math.min(n, most);
  const bytes = (2 * allVoxels) / 1e9;
  const encoding = finest("encode") / n;
  const sample = (total("bunny", "range and sample") * bunnySlices) / voxels[2];
  const begin = { "rank 0 reads the sample": sample };
  const disk = { "the file system": bytes / given.readGBs };
  const written = { "writing the store": finest("encoded blocks") / given.writeGBs };
  if (n === 1) {
    const work = finest("read") + finest("encode") + finest("receive");
    return [begin, { encoding: work, ...disk, ...written }, { encoding: coarser("encode") }];
  }
  // A rank that also reads, sends or receives encodes less.
  const shared = (finest("read") + finest("send") + finest("receive")) / n;
  return [
    begin,
    {
      encoding: encoding + shared,
      reading: ofRanks(finest("read"), layers),
      // One layer is built after the other, and one rank has all voxels of a layer.
      "sending a layer's blocks": finest("send") + onNetwork(finest("tasks")),
      "rank 0 receives blocks": finest("receive") + onNetwork(finest("encoded blocks")),
      ...disk,
      ...written,
    },
    {
      encoding: (coarser("encode") + coarser("send") + coarser("receive")) / n,
      "rank 0 sends and receives coarse blocks":
        coarser("send") +
        coarser("receive") +
        onNetwork(coarser("tasks") + coarser("encoded blocks")),
    },
  ];
}

/** The time of a build, what it is relative to one rank, and what limits level 0. */
export function ranksTable(): string {
  const seconds = (n: number) => stepsOf(n).reduce((sum, step) => sum + longest(step), 0);
  const one = seconds(1);
  const rows = ranks.map((n) => {
    const level0 = stepsOf(n)[1] ?? {};
    const limit = Object.entries(level0).find(([, time]) => time === longest(level0))?.[0] ?? "";
    const times = one / seconds(n);
    return [
      n.toLocaleString("en"),
      ...stepsOf(n).map((step) => amount(longest(step))),
      amount(seconds(n)),
      short(times),
      short((100 * times) / n),
      limit,
    ];
  });
  const heading = [
    "ranks",
    "sample, s",
    "level 0, s",
    "coarser levels, s",
    "all, s",
    "× one rank",
    "efficiency, %",
    "level 0 is limited by",
  ];
  return markdown([heading, heading.map(() => "---"), ...rows]);
}

/** The parts on which the table is based. */
export function rankPartsTable(): string {
  const row = (name: string, measure: string, how: string) => [
    name,
    amount(finest(measure), "s"),
    amount(coarser(measure), "s"),
    how,
  ];
  return markdown([
    ["processor time", "level 0", "coarser levels", "who"],
    ["---", "---", "---", "---"],
    row("read and quantize", "read", "the rank of the layer; at most one for each layer"),
    row("copy blocks to messages", "send", "the rank of the present layer; coarser levels: rank 0"),
    row("encode", "encode", "all ranks"),
    row("receive encoded blocks, and write", "receive", "rank 0"),
  ]);
}

/** The efficiency of two ranks with one thread each, by processor time alone. */
export function twoRanks(): string {
  const threads = finest("read") + finest("encode") + coarser("encode");
  const messages = ["send", "receive"].reduce((sum, part) => sum + finest(part) + coarser(part), 0);
  return `By these parts alone, two ranks would reach ${short(threads / (threads + messages))} of the rate of two threads.`;
}

export function rankAssumptions(): string {
  return [
    `${voxels.join(" × ")} voxels of 16 bits, ${layers} layers of blocks, with the surface of the bunny`,
    `a message travels with ${given.networkGBs} GB/s`,
    `the file system reads ${given.readGBs} GB/s for all ranks together, and writes ${given.writeGBs} GB/s for rank 0`,
    "the processor time of a part does not depend on the number of ranks",
  ]
    .map((line) => `- ${line}`)
    .join("\n");
}
