import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { describe, expect, it } from "vitest";
import { trackedFiles } from "../support/source_graph.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));
const read = (file: string) => readFileSync(join(root, file), "utf8");

/** YAML as JSON, by PyYAML. It takes the key `on` for the truth value, whose name in JSON is `true`. */
const parse = (files: string[]) =>
  JSON.parse(
    execFileSync(
      "python3",
      [
        "-c",
        "import json, sys, yaml; print(json.dumps([yaml.safe_load(open(f)) for f in sys.argv[1:]]))",
        ...files.map((file) => join(root, file)),
      ],
      { encoding: "utf8", stdio: "pipe" },
    ),
  );

interface Step {
  uses?: string;
  run?: string;
}
interface Job {
  "timeout-minutes"?: number;
  container?: string | { image: string };
  steps: Step[];
  strategy?: { matrix: Record<string, unknown> };
}
interface Workflow {
  name: string;
  true: Record<string, unknown>;
  permissions: Record<string, string>;
  jobs: Record<string, Job>;
}

const files = trackedFiles(root, ".github/workflows/*.yml");
const workflows = parse(files) as Workflow[];
const jobs = workflows.flatMap((workflow, i) =>
  Object.entries(workflow.jobs).map(([name, job]) => [`${files[i]}: ${name}`, job] as const),
);
const steps = jobs.flatMap(([name, job]) => job.steps.map((step) => ({ name, job, step })));
const { scripts, engines } = JSON.parse(read("package.json")) as {
  scripts: Record<string, string>;
  engines: { node: string };
};

/** The words that `.ci/NAME` has as cases: the parts of `npm test` and `npm run build`. */
const parts = (script: string) =>
  [...read(`.ci/${script}`).matchAll(/^ +((?:\w+ \| )*\w+)\) /gm)].flatMap((match) =>
    (match[1] ?? "").split(" | "),
  );

describe("workflows", () => {
  it("test pushes, run slow tests on a schedule, and make packages for tags", () => {
    const triggers = workflows.flatMap((workflow) => Object.keys(workflow.true));
    expect(triggers).toEqual(expect.arrayContaining(["push", "pull_request", "schedule"]));
    for (const { permissions } of workflows) expect(permissions).toEqual({ contents: "read" });
  });

  it("run scripts that exist", () => {
    let found = 0;
    for (const { name, job, step } of steps) {
      const command = step.run ?? "";
      // These commands prepare a container before the scripts, or make the draft of a release.
      if (command === "" || /^(git config|apt-get|gh release create) /.test(command)) continue;
      const [, test, script, part] =
        command.match(/^npm (?:(test)|run ([\w:]+))(?: -- (.+))?$/) ?? [];
      expect(test ?? script, `${name}: ${command}`).toBeDefined();
      expect(Object.keys(scripts)).toContain(test ?? script);
      const chosen = part?.includes("matrix.part")
        ? (job.strategy?.matrix.part as string[])
        : [part];
      for (const word of chosen) {
        if (word && test) expect(parts("test"), command).toContain(word);
        if (word && script === "build") expect(parts("build"), command).toContain(word);
      }
      found += 1;
    }
    expect(found).toBeGreaterThan(8);
  });

  it("run the whole check and every part of the tests", () => {
    const commands = steps.flatMap(({ step }) => step.run ?? []);
    for (const command of [
      "npm run check",
      "npm test",
      "npm test -- pictures",
      "npm run release",
    ]) {
      expect(commands).toContain(command);
    }
    const slow = jobs.find(([name]) => name.endsWith("weekly.yml: slow"))?.[1];
    expect(slow?.strategy?.matrix.part).toEqual(["sanitizers", "threads", "definitions"]);
  });

  it("pin the actions of others to commits", () => {
    const actions = steps.flatMap(({ step }) => step.uses ?? []);
    expect(actions.length).toBeGreaterThan(5);
    for (const action of actions) expect(action).toMatch(/^[\w-]+\/[\w-]+@[0-9a-f]{40}$/);
  });

  it("have the Node version that package.json requires", () => {
    const wanted = engines.node.match(/\d+/)?.[0];
    const images = jobs.flatMap(([, { container }]) =>
      typeof container === "object" ? container.image : [],
    );
    expect(images.length).toBeGreaterThan(2);
    expect([...new Set(images)]).toEqual([`node:${wanted}-bookworm`]);
  });

  it("build with the compilers and systems that are supported", () => {
    const native = jobs.find(([name]) => name.endsWith("ci.yml: native"))?.[1];
    const rows = native?.strategy?.matrix.include as { system: string; cxx: string }[];
    const compilers = rows.map(({ cxx }) => cxx);
    expect(compilers).toEqual(expect.arrayContaining(["g++-12", "g++-13", "g++-14", "clang++"]));
    const systems = new Set(rows.map(({ system }) => system));
    expect([...systems]).toEqual(["debian:12", "debian:13", "ubuntu:24.04"]);
  });
});

it("issue templates have what a form needs", () => {
  const templates = trackedFiles(root, ".github/ISSUE_TEMPLATE/*.yml").filter(
    (file) => !file.endsWith("/config.yml"),
  );
  expect(templates.length).toBeGreaterThan(1);
  interface Item {
    type: string;
    id?: string;
    attributes: { label?: string; value?: string };
  }
  const forms = parse(templates) as { name: string; description: string; body: Item[] }[];
  for (const { name, description, body } of forms) {
    expect(name).toMatch(/./);
    expect(description).toMatch(/./);
    const ids = body.flatMap(({ id }) => id ?? []);
    expect(new Set(ids).size).toBe(ids.length);
    for (const { type, attributes } of body) {
      expect(["markdown", "input", "textarea", "dropdown", "checkboxes"]).toContain(type);
      expect(type === "markdown" ? attributes.value : attributes.label).toMatch(/./);
    }
  }
});
