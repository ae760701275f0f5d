// Makes view.html, one file with all that the page needs: node build.mjs FOLDER, where FOLDER holds
// node_modules and gets the page.
import { readFileSync, renameSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const folder = resolve(process.argv[2]);

function load(name) {
  try {
    return createRequire(join(folder, 'package.json'))(name);
  } catch {
    console.error(`view: ${name} is not in ${folder}/node_modules`);
    process.exit(1);
  }
}
const { buildSync } = load('esbuild');

function bundle(entry) {
  const result = buildSync({
    entryPoints: [join(here, entry)],
    bundle: true,
    minify: true,
    write: false,
    format: 'iife',
    target: 'es2020',
    legalComments: 'inline',
    nodePaths: [join(folder, 'node_modules')],
  });
  return result.outputFiles[0].text;
}

const parts = {
  style: bundle('style.css').replace(/<\/style/g, '<\\/style'),
  script: bundle('main.js').replace(/<\/script/g, '<\\/script'),
};
const page = readFileSync(join(here, 'index.html'), 'utf8')
    .replace(/<!--(style|script)-->/g, (_, name) => parts[name]);
const out = join(folder, 'view.html');
writeFileSync(out + '.part', page);
renameSync(out + '.part', out);
