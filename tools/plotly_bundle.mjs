// Build compare/report/plotly/heatmap.js.gz: what femic's charts in a plane need of plotly.js, and nothing else.
//
//   npm install plotly.js@4.1.1 esbuild@0.28.1 esbuild-plugin-environment@0.4.0 \
//     esbuild-plugin-inline-css@0.0.1
//   node plotly_bundle.mjs | gzip -9n > heatmap.js.gz
//
// It is plotly.js's own recipe for custom bundles (its traces are scatter, which every bundle has, and heatmap),
// from the npm package instead of a clone.
import { build } from "esbuild";
import { environmentPlugin } from "esbuild-plugin-environment";
import styles from "esbuild-plugin-inline-css";

const { outputFiles } = await build({
  stdin: {
    contents: "const Plotly = require('plotly.js/lib/core'); Plotly.register([require('plotly.js/lib/heatmap')]); window.Plotly = Plotly;",
    resolveDir: process.cwd(),
  },
  bundle: true,
  minify: true,
  write: false,
  target: "es2022",
  define: { global: "window", "define.amd": "false" },
  plugins: [styles(), environmentPlugin({ NODE_DEBUG: false })],
});
process.stdout.write(outputFiles[0].contents);
