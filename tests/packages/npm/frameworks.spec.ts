// The types of the element in React, Vue and Svelte: valid uses compile, and invalid uses do not.
import { execFile } from "node:child_process";
import { join } from "node:path";
import { promisify } from "node:util";
import { afterAll, beforeAll, expect, test } from "vitest";
import { type Consumer, root } from "./consumer.ts";
import { frameworkProject } from "./frameworks.ts";

let project: Consumer;

beforeAll(() => {
  project = frameworkProject();
}, 120_000);
afterAll(() => project.remove());

const react = `
import "isosplat/react";
import { useRef } from "react";
import type { IsosplatViewerElement } from "isosplat/element";

export function View() {
  const view = useRef<IsosplatViewerElement>(null);
  // @ts-expect-error: isovalues are numbers
  const wrong = <isosplat-viewer isovalues={["60.5"]} />;
  // @ts-expect-error: the element has no such event
  const other = <isosplat-viewer onvaluechange={() => {}} />;
  // @ts-expect-error: the detail of this event is a list of numbers
  const listener = <isosplat-viewer onisovaluechange={({ detail }) => detail.azimuth} />;
  return (
    <isosplat-viewer
      ref={view}
      className="large"
      src="head.isosplat"
      surfaces={[{ isovalue: 60.5, colour: "#d9ccb3", opacity: 1 }]}
      projection="orthographic"
      scene="run.isobundle"
      step={3}
      onstepchange={({ detail }) => console.log(detail.toFixed(0))}
      oncamerachange={({ detail }) => console.log(detail.azimuth, view.current?.info?.range)}
      onfault={(event) => console.log(event.detail.message)}
    >
      {wrong} {other} {listener}
      {/* @ts-expect-error: visible is true or false */}
      <isosplat-layer src="dose.isosplat" visible="no" />
      <isosplat-layer
        src="dose.isosplat"
        name="Dose"
        visible={false}
        onisovaluechange={({ detail }) => console.log(detail[0]?.toFixed(1))}
      />
    </isosplat-viewer>
  );
}
`;

const vue = `

import "isosplat/vue";
import type { GlobalComponents } from "vue";

type Props = InstanceType<GlobalComponents["isosplat-viewer"]>["$props"];
export const props: Props = {
  class: "large",
  src: "head.isosplat",
  isovalues: [60.5],
  onIsovaluechange: ({ detail }) => console.log(detail[0]?.toFixed(1)),
};
// @ts-expect-error: isovalues are numbers
export const wrong: Props = { isovalues: ["60.5"] };
type LayerProps = InstanceType<GlobalComponents["isosplat-layer"]>["$props"];
export const layer: LayerProps = { src: "dose.isosplat", visible: false, onFault: () => {} };
// @ts-expect-error: visible is true or false
export const wrongLayer: LayerProps = { visible: "no" };
// @ts-expect-error: the detail of this event is a camera
export const listener: Props = { onCamerachange: ({ detail }) => detail.length };
`;

const svelte = `

import "isosplat/svelte";
import type { SvelteHTMLElements } from "svelte/elements";

type Props = SvelteHTMLElements["isosplat-viewer"];
export const props: Props = {
  class: "large",
  src: "head.isosplat",
  isovalues: [60.5],
  onisovaluechange: ({ detail }) => console.log(detail[0]?.toFixed(1)),
};
// @ts-expect-error: isovalues are numbers
export const wrong: Props = { isovalues: ["60.5"] };
type LayerProps = SvelteHTMLElements["isosplat-layer"];
export const layer: LayerProps = { src: "dose.isosplat", visible: false, onfault: () => {} };
// @ts-expect-error: visible is true or false
export const wrongLayer: LayerProps = { visible: "no" };
// @ts-expect-error: the detail of this event is a camera
export const listener: Props = { oncamerachange: ({ detail }) => detail.length };
`;

test("the types of the element hold in React, Vue and Svelte, and in the README's example", async () => {
  const sources = { "view.tsx": react, "view_vue.ts": vue, "view_svelte.ts": svelte };
  for (const [file, text] of Object.entries(sources)) project.write(file, text);
  const compilerOptions = {
    target: "es2022",
    module: "esnext",
    moduleResolution: "bundler",
    lib: ["es2022", "dom", "dom.iterable"],
    types: [],
    jsx: "react-jsx",
    strict: true,
    exactOptionalPropertyTypes: true,
    // The declarations of the frameworks are not ours to check; those of the package are checked by
    // what the sources expect of them.
    skipLibCheck: true,
    noEmit: true,
  };
  const files = [...Object.keys(sources), "react.tsx"];
  project.write("tsconfig.json", JSON.stringify({ compilerOptions, files }));
  const tsc = join(root, "node_modules/.bin/tsc");
  const printed = await promisify(execFile)(tsc, ["-p", project.folder]).then(
    ({ stdout }) => stdout,
    (error: { stdout: string }) => error.stdout,
  );
  expect(printed).toBe("");
});
