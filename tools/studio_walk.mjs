// node tools/studio_walk.mjs ADDRESS FOLDER [CHROMIUM] [TABLE.md]
// What a newcomer does in a quarter of an hour, in a studio that runs at ADDRESS: a line, an emotion, a slider, a key, a
// wrong sound, two takes side by side, files. Says how long each answer took, and writes that as a table if TABLE.md is
// given (docs/tables/studio_walk.md). Pictures and files go into FOLDER.
import { writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { loadavg } from 'node:os';
import { join } from 'node:path';

const [address, folder, executablePath = '/usr/bin/chromium', table] = process.argv.slice(2);
const { chromium } = createRequire(new URL('../studio/package.json', import.meta.url))('playwright-core');
const browser = await chromium.launch({ executablePath, args: ['--headless', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
  '--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking', '--autoplay-policy=no-user-gesture-required'] });
const rows = [];
try {
  const page = await (await browser.newContext({ viewport: { width: 1280, height: 720 }, acceptDownloads: true })).newPage();
  page.setDefaultTimeout(300_000);
  const shot = (name) => page.screenshot({ path: join(folder, `${name}.png`) });
  const idle = async () => {
    await page.waitForFunction(() => document.querySelector('.told').childElementCount === 0);
    await page.waitForFunction(() => document.body.dataset.kept !== 'false');
  };
  const timed = async (what, act) => {
    const began = performance.now();
    await act();
    const seconds = (performance.now() - began) / 1000;
    rows.push([what, seconds.toFixed(2)]);
    console.log(`${seconds.toFixed(2)} s  ${what}`);
  };
  const shown = () => page.evaluate(() => { const now = window.mienStats.shown(); return now === null ? '' : `${now.take} ${now.revision}`; });
  const performed = async (act) => {
    const before = await shown();
    await act();
    await page.waitForFunction((known) => { const now = window.mienStats.shown(); return now !== null && `${now.take} ${now.revision}` !== known; }, before);
    await idle();
  };
  const told = () => page.evaluate(async () => (await fetch(`/api/takes/${window.mienStats.shown().take}`)).json());
  const drag = async (x, y, toX, toY) => { await page.mouse.move(x, y); await page.mouse.down(); await page.mouse.move(toX, toY, { steps: 4 }); };

  await timed('the page opens', async () => { await page.goto(address); await page.waitForSelector('body[data-ready]'); });
  await page.waitForTimeout(3000);
  await page.fill('#field-text', '');
  await page.locator('#field-text').pressSequentially('I never said that we should leave.', { delay: 60 });
  await page.waitForTimeout(1000);
  await timed('a line is typed, Enter: it is there', () => performed(() => page.press('#field-text', 'Enter')));
  await timed('an emotion is clicked: performed', () => performed(() => page.click('[data-emotion=sad]')));
  const slider = await page.locator('#strength').boundingBox();
  const length = await page.evaluate(() => window.mienStats.shown().values.length);
  await timed('the strength is slid: heard and seen while it is held', async () => {
    await drag(slider.x + slider.width * 0.7, slider.y + 8, slider.x + slider.width - 6, slider.y + 8);
    await page.waitForFunction((before) => window.mienStats.shown().values.length !== before || document.querySelector('.play').getAttribute('aria-label') === 'Pause', length);
  });
  await shot('slid');
  await timed('it is let go: performed', () => performed(() => page.mouse.up()));
  const lane = await page.locator('.channel[data-lane=jawOpen] .body').boundingBox();
  await timed('a double click on a lane: a key', async () => {
    await page.mouse.dblclick(lane.x + lane.width * 0.4, lane.y + 14);
    await page.waitForSelector('.channel[data-lane=jawOpen] .handle');
    await idle();
  });
  const key = await page.locator('.channel[data-lane=jawOpen] .handle').first().boundingBox();
  await timed('the key is dragged: kept', async () => { await drag(key.x + key.width / 2, key.y + key.height / 2, key.x + 30, key.y + 8); await page.mouse.up(); await idle(); });
  const before = await told();
  const place = before.phones.findIndex(([, , label]) => label === 'EH');
  const middle = (before.phones[place][0] + before.phones[place][1]) / 2;
  const phones = await page.locator('.phones .body').boundingBox();
  await page.mouse.dblclick(phones.x + 12 + (phones.width - 24) * (middle / before.seconds), phones.y + 10);
  await page.waitForSelector('dialog[open]');
  await shot('sound');
  await timed('a wrong sound is corrected (EH to AE): performed', () => performed(() => page.locator('dialog[open] .choices button', { hasText: 'AE' }).first().click()));
  await page.reload();
  await page.waitForSelector('body[data-ready]');
  await page.waitForFunction(() => window.mienStats.shown() !== null);
  await idle();
  if ((await told()).phones[place][2] !== 'AE') throw new Error('the corrected sound is lost after a reload');
  await page.click('#tab-edits');
  await shot('edits');
  await page.click('#tab-takes');
  const first = (await shown()).split(' ')[0];
  await timed('the take is duplicated: the copy is open', async () => {
    await page.getByLabel(/^Duplicate/).first().click();
    await page.waitForFunction((known) => window.mienStats.shown().take !== known, first);
    await idle();
  });
  await page.click('#tab-line');
  await timed('the copy is made happy: performed', () => performed(() => page.click('[data-emotion=happy]')));
  await page.click('#tab-takes');
  await timed('both are compared, side by side', async () => { await page.getByLabel(/^Compare with/).last().click(); await page.waitForSelector('.compare:not([hidden])'); await idle(); });
  await page.waitForTimeout(1500);
  await shot('compared');
  await page.click('#tab-export');
  for (const box of await page.locator('.formats input').all()) await box.setChecked(['.mp4', '.glb', '.TextGrid'].includes(await box.getAttribute('value')));
  await timed('MP4, GLB and TextGrid are exported: downloaded', async () => {
    const [file] = await Promise.all([page.waitForEvent('download'), page.click('#export')]);
    await file.saveAs(join(folder, file.suggestedFilename()));
  });
  await shot('exported');
  if (table !== undefined) {
    writeFileSync(table, `# What a newcomer does, and how long the studio takes to answer

\`node tools/studio_walk.mjs ADDRESS FOLDER CHROMIUM docs/tables/studio_walk.md\`: Chromium without a window at 1280 x 720, drawn by software on the
same processors as the server; the load of the machine was ${loadavg()[0].toFixed(1)}. "I never said that we should leave."

| | seconds |
| --- | --- |
${rows.map((row) => `| ${row.join(' | ')} |`).join('\n')}
`);
  }
} finally {
  await browser.close();
}
