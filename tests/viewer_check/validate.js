// node validate.js FILE... : the Khronos validator on each file; one JSON line each with its errors.
import { readFile } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import validator from 'gltf-validator';

for (const file of process.argv.slice(2)) {
  const bytes = new Uint8Array(await readFile(file));
  const externalResourceFunction = async (uri) => new Uint8Array(await readFile(join(dirname(file), decodeURIComponent(uri))));
  const report = await validator.validateBytes(bytes, { maxIssues: 500, externalResourceFunction });
  const errors = report.issues.messages.filter((issue) => issue.severity === 0);
  console.log(JSON.stringify({ file, errors: errors.map((issue) => `${issue.code} ${issue.pointer} ${issue.message}`) }));
}
