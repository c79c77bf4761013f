// node check.mjs PACKAGE ADDRESS CHROMIUM FOLDER SOUND.wav FACE.tree
// Does the whole job in the studio's page as a person would, and prints what was seen as one JSON line. PACKAGE is the
// folder whose node_modules hold playwright-core. Pictures and downloads go into FOLDER.
import { createRequire } from 'node:module';
import { join } from 'node:path';

const [packageFolder, address, executablePath, folder, sound, tree] = process.argv.slice(2);
const { chromium } = createRequire(join(packageFolder, 'package.json'))('playwright-core');
// Software rendering; and no calls home, which a closed network would only refuse.
const ARGUMENTS = [
  '--headless', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-sandbox', '--disable-quic', '--no-first-run',
  '--disable-background-networking', '--disable-component-update', '--disable-sync', '--autoplay-policy=no-user-gesture-required',
];
const seen = { complaints: [], elsewhere: [], requests: 0 };
const READY = 60_000;

const browser = await chromium.launch({ executablePath, args: ARGUMENTS });
try {
  // Half the points each way: what is drawn by software is most of the time that this takes.
  const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, deviceScaleFactor: 0.5, colorScheme: 'dark', acceptDownloads: true });
  const page = await context.newPage();
  page.setDefaultTimeout(READY);
  page.on('pageerror', (error) => seen.complaints.push(String(error)));
  page.on('console', (line) => { if (['error', 'warning'].includes(line.type())) seen.complaints.push(line.text()); });
  page.on('request', (request) => {
    seen.requests += 1;
    const url = request.url();
    if (!url.startsWith(address) && !url.startsWith('blob:') && !url.startsWith('data:')) seen.elsewhere.push(url);
  });
  const shown = (name) => page.evaluate((channel) => {
    const now = window.mienStats.shown();
    return [...now.values].filter((_, place) => place % now.channels.length === now.channels.indexOf(channel));
  }, name);
  const takeNow = () => page.evaluate(() => { const now = window.mienStats.shown(); return now === null ? '' : `${now.take} ${now.revision}`; });
  const performed = async (before) => {
    await page.waitForFunction((take) => { const now = window.mienStats.shown(); return now !== null && `${now.take} ${now.revision}` !== take; }, before);
    await page.waitForFunction(() => document.querySelector('.told').childElementCount === 0);
  };
  const edited = (act) => Promise.all([page.waitForResponse((answer) => answer.request().method() === 'PUT' && answer.url().endsWith('/steps') && answer.ok()), act()]);
  const settled = async () => { // performed, and drawn
    await page.waitForFunction(() => document.querySelector('.told').childElementCount === 0);
    await page.evaluate(() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn))));
  };
  const drag = async (handle, x, y, during) => {
    const box = await handle.boundingBox();
    const [left, top] = [box.x + box.width / 2, box.y + box.height / 2];
    await page.mouse.move(left, top);
    await page.mouse.down();
    await page.mouse.move(left + x / 2, top + y / 2);
    await page.mouse.move(left + x, top + y);
    const found = await during?.();
    await page.mouse.up();
    return found;
  };
  const edits = () => page.locator('.edits .edit').allTextContents();
  const sum = (values) => values.reduce((total, one) => total + one, 0);

  // A line is typed and performed.
  await page.goto(address);
  await page.waitForSelector('body[data-ready]');
  await page.fill('#field-text', 'I never said that.');
  await page.click('[data-emotion=happy]');
  await page.press('#field-text', 'Enter');
  await performed('');
  seen.take = await page.evaluate(() => ({ frames: window.mienStats.shown().values.length / window.mienStats.shown().channels.length, text: document.querySelector('.clock').textContent }));

  // It plays in slow motion, so that a slow machine finds it still playing; a click on the sound scrubs.
  await page.selectOption('.transport select', '0.25');
  await page.click('[data-do=play]');
  const playing = await page.waitForFunction(() => window.mienStats.shown().seconds > 0.1 && document.querySelector('.play').getAttribute('aria-label'));
  seen.playing = await playing.jsonValue();
  seen.speed = await page.evaluate(() => document.querySelector('.transport select').value);
  await page.click('[data-do=play]');
  await page.selectOption('.transport select', '1');
  const wave = await page.locator('.wave .body').boundingBox();
  await page.mouse.click(wave.x + wave.width * 0.4, wave.y + 20);
  seen.scrubbed = await page.evaluate(() => window.mienStats.shown().seconds);
  seen.times = await page.evaluate(() => window.mienStats.summary());

  // An intensity is dragged: the face follows before the mouse is let go.
  const smile = sum(await shown('mouthSmileLeft'));
  await page.waitForSelector('.emotion .handle');
  const point = page.locator('.emotion .handle').last();
  const [, during] = await edited(() => drag(point, 0, 22, async () => {
    for (let look = 0; look < 60; look++) { // the first time the page asks for the line without its emotion
      const now = sum(await shown('mouthSmileLeft'));
      if (now !== smile) return now;
      await page.waitForTimeout(200);
    }
    return smile;
  }));
  await settled();
  seen.intensity = { before: smile, during, after: sum(await shown('mouthSmileLeft')) };

  // A border is dragged.
  const border = page.locator('.phones .handle').nth(4);
  const where = { before: Number(await border.getAttribute('aria-valuenow')) };
  await edited(() => drag(border, 14, 0));
  await settled();
  where.after = Number(await border.getAttribute('aria-valuenow'));
  seen.border = where;

  // Keys of a channel: what the page shows is what the server performs.
  const lane = await page.locator('.channel[data-lane=jawOpen] .body').boundingBox();
  await edited(() => page.mouse.dblclick(lane.x + lane.width * 0.3, lane.y + 9));
  await edited(() => page.mouse.dblclick(lane.x + lane.width * 0.5, lane.y + 30));
  await page.locator('.channel[data-lane=jawOpen] .handle').first().click({ button: 'right', force: true }); // keys snap
  await edited(() => page.getByRole('menuitemradio', { name: 'step' }).click());
  await page.waitForSelector('.channel[data-lane=jawOpen] .handle[data-tangent=step]', { timeout: 5000 }).catch(() => undefined);
  seen.tangents = await page.locator('.channel[data-lane=jawOpen] .handle').evaluateAll((keys) => keys.map((key) => key.dataset.tangent));
  await settled();
  seen.apart = await page.evaluate(async () => {
    const now = window.mienStats.shown();
    const theirs = new Float32Array(await (await fetch(`/api/takes/${now.take}/frames`)).arrayBuffer());
    return theirs.length === now.values.length ? theirs.reduce((most, one, place) => Math.max(most, Math.abs(one - now.values[place])), 0) : -1;
  });
  await page.click('#tab-edits');
  seen.edits = await edits();
  await page.screenshot({ path: join(folder, 'desk.png') });

  // Pointing at an effort or a direction shows it before anything is performed.
  await page.click('#tab-line');
  seen.hovered = [sum(await shown('jawOpen'))];
  await page.hover('[data-effort="1.9"]');
  seen.hovered.push(sum(await shown('jawOpen')));
  await page.hover('[data-gaze=left]');
  seen.hovered.push(Math.min(...await shown('eyeLookOutLeft')));
  await page.mouse.move(300, 300);
  seen.hovered.push(sum(await shown('jawOpen')));

  // A slider under the finger: the line is heard and seen so while it is held, and as before once it is let go where it was.
  const length = () => page.evaluate(() => window.mienStats.shown().values.length);
  const [slider, whole] = [page.locator('#field-voice_emotion'), await length()];
  await slider.scrollIntoViewIfNeeded();
  const track = await slider.boundingBox();
  await page.mouse.move(track.x + track.width - 8, track.y + track.height / 2);
  await page.mouse.down();
  await page.mouse.move(track.x + 8, track.y + track.height / 2);
  await page.waitForFunction((before) => window.mienStats.shown().values.length !== before && document.querySelector('.play').getAttribute('aria-label') === 'Pause', whole);
  seen.slid = { promise: await page.locator('.manner .help:not([hidden])').last().innerText(), other: (await length()) - whole };
  await page.mouse.move(track.x + track.width - 8, track.y + track.height / 2);
  await page.mouse.up();
  await page.waitForFunction((before) => window.mienStats.shown().values.length === before, whole);
  seen.slid.back = (await length()) - whole;

  // What is shown is sent to an engine, until the button is pressed again.
  await page.click('[data-do=live]');
  await page.fill('#field-to', '127.0.0.1:9');
  await page.click('.live-dialog .primary');
  await page.waitForSelector('[data-do=live][aria-pressed=true]');
  seen.live = await page.evaluate(async () => (await fetch('/api/live')).json());
  await page.click('[data-do=live]');
  await page.waitForSelector('[data-do=live][aria-pressed=false]');

  // A TextGrid is dropped.
  const grid = await page.evaluate(async () => {
    const { take } = window.mienStats.shown();
    const { words, phones, seconds } = await (await fetch(`/api/takes/${take}`)).json();
    const moved = words.map(([begin, end, word], place) => [begin, place === words.length - 1 ? end - 0.02 : end, word]);
    const tier = (name, spans) => `"IntervalTier" "${name}" 0 ${seconds} ${spans.length} ${spans.map(([begin, end, label]) => `${begin} ${end} "${label}"`).join(' ')}`;
    const content = `File type = "ooTextFile" Object class = "TextGrid" 0 ${seconds} <exists> 2 ${tier('words', moved)} ${tier('phones', phones)}`;
    const files = new DataTransfer();
    files.items.add(new File([content], 'line.TextGrid'));
    document.dispatchEvent(new DragEvent('drop', { dataTransfer: files, bubbles: true, cancelable: true }));
    return moved.at(-1)[1];
  });
  await page.waitForFunction(async (end) => {
    const { take } = window.mienStats.shown();
    return Math.abs((await (await fetch(`/api/takes/${take}`)).json()).words.at(-1)[1] - end) < 1e-3;
  }, grid);
  await settled();
  seen.grid = true;
  await edited(() => page.keyboard.press('Control+z'));
  await settled();
  await page.click('#tab-edits');

  // Undo and redo.
  await page.mouse.move(5, 5);
  for (let step = 0; step < 4; step++) await edited(() => page.keyboard.press('Control+z'));
  await settled();
  seen.undone = await edits();
  await edited(() => page.keyboard.press('Control+y'));
  await settled();
  seen.redone = await edits();

  // The line again in another emotion keeps the edits.
  await page.click('#tab-line');
  const before = await takeNow();
  const calm = sum(await shown('browDownLeft'));
  await page.click('[data-emotion=angry]');
  seen.atOnce = sum(await shown('browDownLeft')) - calm; // before the server has answered
  await performed(before);
  await page.click('#tab-edits');
  seen.kept = await edits();

  // A GLB is exported.
  await page.click('#tab-export');
  for (const box of await page.locator('.formats input').all()) await box.setChecked((await box.getAttribute('value')) === '.glb');
  const [file] = await Promise.all([page.waitForEvent('download'), page.click('#export')]);
  seen.exported = file.suggestedFilename();
  await file.saveAs(join(folder, 'exported.glb'));
  await settled();

  // What was exported is opened as the face.
  await page.setInputFiles('#field-face', join(folder, 'exported.glb'));
  await page.waitForSelector('.report h3', { state: 'attached' });
  await page.click('#tab-face');
  seen.face = await page.locator('.report').innerText();
  await page.click('[data-face=default]');

  // The deformation editor: a tree is opened, moved, painted, saved; the server's own posing is the referee.
  await page.click('#tab-rig');
  await page.setInputFiles('#field-tree', tree);
  await page.waitForFunction(() => window.mienStats.tree());
  await settled();
  await page.selectOption('#field-parameter', 'jaw');
  await page.locator('#field-value').evaluate((slider) => {
    slider.value = '12';
    slider.dispatchEvent(new Event('input', { bubbles: true }));
  });
  const apartFromServer = () => page.evaluate(async () => {
    const { rig, values, vertices } = window.mienStats.tree();
    const asked = { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ values }) };
    const theirs = new Float32Array(await (await fetch(`/api/rigs/${rig}/pose`, asked)).arrayBuffer());
    const ours = vertices.flatMap((part) => [...part]);
    return ours.length === theirs.length ? ours.reduce((most, one, place) => Math.max(most, Math.abs(one - theirs[place])), 0) : -1;
  });
  seen.rig = { apart: await apartFromServer() };
  await page.selectOption('#field-parameter', 'smile');
  await page.click('#paint');
  const picture = await page.locator('.backdrop').boundingBox();
  await page.mouse.move(picture.x + picture.width * 0.46, picture.y + picture.height * 0.5);
  await page.mouse.down();
  await page.mouse.move(picture.x + picture.width * 0.47, picture.y + picture.height * 0.52);
  await page.mouse.up();
  await page.screenshot({ path: join(folder, 'rig.png') });
  await page.locator('.vector input').first().fill('7');
  const [saved] = await Promise.all([page.waitForEvent('download'), page.click('#save-tree')]);
  await saved.saveAs(join(folder, 'saved.tree'));
  await settled();
  seen.rig.saved = await apartFromServer();

  // A fault stands at its field.
  await page.click('#tab-line');
  await page.fill('#field-text', '   ');
  await page.click('#perform');
  await page.waitForSelector('#fault-text:not([hidden])');
  seen.fault = await page.locator('#fault-text').innerText();

  // A recording is performed.
  await page.setInputFiles('#field-sound', sound);
  await page.fill('#field-text', 'I never said that.');
  const spoken = await takeNow();
  await page.click('#perform');
  await performed(spoken);
  seen.recorded = await page.locator('.file-name').innerText();

  // The keyboard alone: text, perform, play, a border by a frame, back, help.
  await page.reload();
  await page.waitForSelector('body[data-ready]');
  const focused = () => page.evaluate(() => {
    const at = document.activeElement;
    return at.id || at.dataset.do || at.dataset.key || at.getAttribute('aria-label') || at.tagName;
  });
  const tabTo = async (wanted, most = 40) => {
    for (let press = 0; press < most; press++) {
      await page.keyboard.press('Tab');
      if ((await focused()) === wanted) return press + 1;
    }
    return -1;
  };
  seen.keys = { text: await tabTo('field-text') };
  const reloaded = await takeNow();
  seen.back = reloaded.split(' ')[0] === spoken.split(' ')[0];
  await page.keyboard.press('Control+a');
  await page.keyboard.type('I never said that!');
  await page.keyboard.press('Enter');
  await performed(reloaded);
  seen.keys.play = await tabTo('play');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => window.mienStats.shown().seconds > 0.15);
  await page.keyboard.press('Enter');
  await page.keyboard.press('.');
  seen.keys.border = await tabTo('border-0');
  seen.keys.outline = await page.evaluate(() => getComputedStyle(document.activeElement).outlineStyle);
  await page.keyboard.press('Control+ArrowRight');
  seen.keys.next = await focused();
  await edited(() => page.keyboard.press('ArrowRight'));
  await settled();
  seen.keys.still = await focused();
  await edited(() => page.keyboard.press('Control+z'));
  await settled();
  await page.keyboard.press('?');
  seen.keys.help = await page.locator('dialog[open]').count();
  await page.keyboard.press('Escape');
  await page.waitForSelector('dialog[open]', { state: 'detached' });
  seen.keys.closed = await page.locator('dialog[open]').count();
  await page.keyboard.press('Home');
  await page.keyboard.press(' ');
  await page.waitForFunction(() => window.mienStats.shown().seconds > 0.1);

  // A phone's screen.
  await page.setViewportSize({ width: 390, height: 844 });
  await page.waitForTimeout(600);
  await page.screenshot({ path: join(folder, 'phone-line.png') });
  await page.click('#tab-timeline');
  await page.waitForTimeout(600);
  await page.screenshot({ path: join(folder, 'phone-timeline.png') });
  seen.phone = await page.evaluate(() => ({
    wide: document.documentElement.scrollWidth,
    outside: [...document.querySelectorAll('button, select, textarea')].filter((element) => {
      const box = element.getBoundingClientRect();
      return box.width > 0 && (box.right > innerWidth + 1 || box.left < -1);
    }).map((element) => element.id || element.getAttribute('aria-label')),
  }));
  console.log(JSON.stringify(seen));
} finally {
  await browser.close();
}
