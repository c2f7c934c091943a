import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { afterEach, beforeEach, describe, expect, it } from "vitest";

const script = fileURLToPath(new URL("../../.ci/install-packages", import.meta.url));

let tools: string;

beforeEach(() => {
  tools = mkdtempSync(join(tmpdir(), "isosplat-packages-"));
});
afterEach(() => {
  rmSync(tools, { recursive: true });
});

function tool(name: string, text: string) {
  writeFileSync(join(tools, name), `#!/bin/bash\n${text}\n`, { mode: 0o755 });
}

/** The names of all packages of --list except those of Boost. */
function otherPackages(): string[] {
  const listed = spawnSync("bash", [script, "--list"], { encoding: "utf8" }).stdout;
  return [...listed.matchAll(/^ {2}(\S+)/gm)]
    .map(([, name = ""]) => name)
    .filter((name) => !name.startsWith("libboost"));
}

/** Runs the script with these installed packages, and with these packages and versions in the index. */
function run(
  options: string[],
  installed: Record<string, string>,
  available: Record<string, string>,
) {
  const all = { ...Object.fromEntries(otherPackages().map((name) => [name, "1"])), ...installed };
  const lines = Object.entries(all).map(([name, version]) => `echo 'ii |${name}|${version}'`);
  tool("dpkg-query", lines.join("\n"));
  const cases = Object.entries(available).map(
    ([name, version]) => `${name}) echo '  Candidate: ${version}' ;;`,
  );
  tool("apt-cache", `case $2 in ${cases.join("\n")}\n esac`);
  tool("apt-get", `echo "apt-get $*"`);
  tool("sudo", `[[ $1 != -n ]] || exit 0; exec "$@"`);
  return spawnSync("bash", [script, ...options], {
    encoding: "utf8",
    env: { ...process.env, PATH: `${tools}:${process.env["PATH"]}` },
  });
}

describe(".ci/install-packages", () => {
  it("takes any installed Boost from 1.74 on", () => {
    for (const [name, version] of [
      ["libboost1.74-dev", "1.74.0+ds1-21"],
      ["libboost1.81-dev", "1.81.0-5"],
      ["libboost1.83-dev", "1.83.0-2.1ubuntu3"],
      ["libboost-dev", "1.74.0.3"],
      ["libboost-dev", "1.83.0.2+b2"],
    ] as const) {
      expect(run(["--missing"], { [name]: version }, {}).status).toBe(0);
    }
    const old = run(["--missing"], { "libboost-dev": "1.71.0.0" }, {});
    expect(old.status).toBe(1);
    expect(old.stdout).toContain("libboost1.81-dev");
  });

  it("installs the first name that the package index knows", () => {
    const debian = run([], {}, { "libboost1.81-dev": "1.81.0-5", "libboost-dev": "1.74.0.3" });
    expect(debian.stdout).toMatch(/install -y .* libboost1\.81-dev$/m);
    const old = run([], {}, { "libboost1.83-dev": "1.83.0-2", "libboost-dev": "1.71.0.0" });
    expect(old.stdout).toMatch(/install -y .* libboost1\.83-dev$/m);
    const later = run([], {}, { "libboost-dev": "1.90.0.1" });
    expect(later.stdout).toMatch(/install -y .* libboost-dev$/m);
  });

  it("names the packages that it searched for if the index has none of them", () => {
    const result = run([], {}, { "libboost-dev": "1.71.0.0" });
    expect(result.status).toBe(1);
    expect(result.stderr).toContain("libboost1.81-dev, libboost1.83-dev");
    expect(result.stdout).not.toContain("install -y");
  });
});
