// Counts the tests of every suite from the output of its runner, and prints a table and the sum.
//   node .ci/count-tests.mjs FOLDER
// The folder holds, for each suite, NAME.status (the runner's exit status) and NAME.xml (ctest) or
// NAME.json (GoogleTest, vitest, Playwright, or {passed, failed, skipped}).
import { existsSync, readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";

const folder = process.argv[2];

function countJunit(text) {
  const attribute = (name) =>
    Number(text.match(new RegExp(`<testsuite[^>]*?\\s${name}="(\\d+)"`))?.[1] ?? 0);
  const failed = attribute("failures");
  const skipped = attribute("skipped") + attribute("disabled");
  return { passed: attribute("tests") - failed - skipped, failed, skipped };
}

function countGoogleTest(report) {
  const tests = report.testsuites.flatMap((suite) => suite.testsuite);
  const failed = tests.filter((test) => test.failures?.length).length;
  const skipped = tests.filter(
    (test) => test.result === "SKIPPED" || test.status === "NOTRUN",
  ).length;
  return { passed: tests.length - failed - skipped, failed, skipped };
}

function countJson(report) {
  if (report.testsuites) return countGoogleTest(report);
  if (report.numTotalTests !== undefined) {
    const skipped = report.numPendingTests + (report.numTodoTests ?? 0);
    return { passed: report.numPassedTests, failed: report.numFailedTests, skipped };
  }
  if (report.stats) {
    const { expected, unexpected, flaky, skipped } = report.stats;
    return { passed: expected + flaky, failed: unexpected, skipped, flaky };
  }
  return report;
}

function count(name) {
  const xml = join(folder, `${name}.xml`);
  const json = join(folder, `${name}.json`);
  if (existsSync(xml)) return countJunit(readFileSync(xml, "utf8"));
  if (existsSync(json)) return countJson(JSON.parse(readFileSync(json, "utf8")));
  return { passed: 0, failed: 0, skipped: 0 };
}

const sum = { passed: 0, failed: 0, skipped: 0 };
console.log(
  `\n${"suite".padEnd(18)}${"passed".padStart(8)}${"failed".padStart(8)}${"skipped".padStart(9)}`,
);
for (const file of readdirSync(folder)
  .filter((entry) => entry.endsWith(".status"))
  .sort()) {
  const name = file.slice(0, -".status".length);
  const counted = count(name);
  const status = Number(readFileSync(join(folder, file), "utf8"));
  let note = counted.flaky ? `  ${counted.flaky} of them at the second try only` : "";
  // A runner that failed without naming a failed test crashed, or found nothing to run.
  if (status !== 0 && counted.failed === 0) {
    counted.failed = 1;
    note = `  did not finish (exit status ${status})`;
  } else if (counted.passed + counted.failed === 0) {
    counted.failed = 1;
    note = "  ran no test";
  }
  for (const key of Object.keys(sum)) sum[key] += counted[key];
  const { passed, failed, skipped } = counted;
  console.log(
    `${name.padEnd(18)}${String(passed).padStart(8)}${String(failed).padStart(8)}${String(skipped).padStart(9)}${note}`,
  );
}
console.log(`\n${sum.passed} passed, ${sum.failed} failed, ${sum.skipped} skipped`);
process.exitCode = sum.failed === 0 && sum.passed > 0 ? 0 : 1;
