/** Measures the processor time and memory of a command, independently of other programs on the machine. */
import type { Bench } from "./benchmark.ts";

export interface Used {
  /** The time on all processors, in user and system mode. */
  processorSeconds: number;
  /** The largest resident memory. */
  peakBytes: number;
  stdout: string;
}

/** Runs a command with an input, and prints what the kernel counted for it as JSON. */
const script = `
import json, resource, subprocess, sys
done = subprocess.run(sys.argv[2:], input=sys.argv[1], stdout=subprocess.PIPE, text=True)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(json.dumps({"processorSeconds": used.ru_utime + used.ru_stime,
                  "peakBytes": used.ru_maxrss * 1024, "stdout": done.stdout}))
sys.exit(done.returncode)
`;

/** Runs a command to its end with text on its standard input. Throws if it fails. */
export async function measureUse(
  bench: Bench,
  program: string,
  args: string[],
  input = "",
): Promise<Used> {
  const { stdout } = await bench.command("/usr/bin/python3", [
    "-c",
    script,
    input,
    program,
    ...args,
  ]);
  return JSON.parse(stdout) as Used;
}
