// Draws the charts of a page with Plotly when they come into view, and all of them before the page is printed. Labels
// that are hidden, and sliders of one name, are shared by all charts of the page.
(() => {
  "use strict";
  const root = document.documentElement;
  const hidden = new Set();
  const charts = [];
  const css = name => getComputedStyle(root).getPropertyValue(name).trim();

  // The bundles of Plotly by their names, and what has begun to be unpacked. Nothing stays global, and one is
  // unpacked after the other, so that that for 3D does not replace the other.
  const plotly = {}, begun = {};
  let last = Promise.resolve();
  const unpack = async name => {
    const packed = await fetch(`data:application/gzip;base64,${document.getElementById(`plotly-${name}`).textContent}`);
    const source = await new Response(packed.body.pipeThrough(new DecompressionStream("gzip"))).text();
    const eager = "//# allFunctionsCalledOnLoad\n"; // Chromium compiles while it reads, beside the page; comment to others
    const script = Object.assign(document.createElement("script"), { src: URL.createObjectURL(new Blob([eager, source])) });
    await new Promise((done, failed) => {
      Object.assign(script, { onload: done, onerror: failed }); // a file is compiled while it is read
      document.head.append(script);
    });
    plotly[name] = window.Plotly;
    delete window.Plotly;
  };
  const needed = name => (begun[name] ??= last = last.catch(() => {}).then(() => unpack(name)));
  if (document.getElementById("plotly-heatmap")) needed("heatmap"); // while the page is laid out
  const bundle = cell => (cell.layout.scene ? "gl3d" : "heatmap");

  const faint = colour => {
    const n = parseInt(colour.slice(1), 16);
    return `rgba(${n >> 16}, ${(n >> 8) & 255}, ${n & 255}, 0.2)`;
  };
  const paint = value => {
    if (typeof value !== "string") return value;
    const [colour, tone] = value.split(" ");
    const seen = colour === "ink" ? css("--ink") : colour;
    return tone === "faint" ? faint(seen) : seen;
  };
  const plain = { exponentformat: "power", minexponent: 4 }; // numbers up to 99999 without powers or prefixes
  const painted = trace => {
    const copy = { ...trace };
    if (copy.fillcolor) copy.fillcolor = paint(copy.fillcolor);
    for (const part of ["line", "marker"]) if (copy[part]?.color) copy[part] = { ...copy[part], color: paint(copy[part].color) };
    if (copy.colorbar) copy.colorbar = { ...plain, ...copy.colorbar };
    if (copy.kinds) copy.text = copy.z.map(row => row.map(kind => (kind === null ? "" : copy.kinds[kind])));
    if (copy.legendgroup && hidden.has(copy.legendgroup)) copy.visible = false;
    return copy;
  };
  const axis = given => ({
    gridcolor: css("--grid"), zerolinecolor: css("--grid"), linecolor: css("--grid"), automargin: true, ...plain, ...given,
    title: { ...given?.title, font: { size: 12 }, standoff: 6 },
  });
  const layout = (cell, height) => {
    const own = { ...cell.layout };
    for (const name of ["xaxis", "yaxis"]) if (own[name]) own[name] = axis(own[name]);
    if (own.scene) {
      own.scene = { ...own.scene };
      for (const name of ["xaxis", "yaxis", "zaxis"])
        own.scene[name] = { ...own.scene[name], gridcolor: css("--grid"), backgroundcolor: css("--paper"), color: css("--ink") };
    }
    return {
      height, margin: { l: 52, r: 14, t: 26, b: 42 }, showlegend: false, hovermode: "x unified", uirevision: "kept",
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: { family: "system-ui, sans-serif", size: 12, color: css("--ink") },
      modebar: { bgcolor: "rgba(0,0,0,0)", color: css("--dim"), activecolor: css("--mark") },
      hoverlabel: { bgcolor: css("--paper"), font: { color: css("--ink") } }, ...own,
    };
  };
  const config = {
    displaylogo: false, responsive: true, displayModeBar: "hover",
    modeBarButtonsToRemove: ["lasso2d", "select2d", "zoomIn2d", "zoomOut2d", "autoScale2d", "sendChartToCloud"],
  };

  // The cells of the present step: all, or the one that is chosen.
  const shown = chart => {
    const cells = chart.content.steps[chart.step];
    return chart.content.choice ? [cells[chart.chosen]] : cells;
  };
  const named = (chart, cell) => {
    const axes = ["yaxis", "xaxis"].map(name => cell.layout[name]?.title.text).filter(Boolean).join(" over ");
    return [chart.content.alt || chart.content.name.replaceAll("_", " "), chart.output?.textContent, cell.title, axes].filter(Boolean).join(", ");
  };
  const draw = chart => {
    if (!chart.seen) return;
    shown(chart).forEach((cell, k) => {
      const name = bundle(cell), plot = chart.cells[k];
      chart.titles[k].textContent = cell.title;
      if (!plotly[name]) return void needed(name).then(() => draw(chart));
      const onPaper = "paper" in root.dataset, width = onPaper ? { width: plot.clientWidth } : {};
      plot.style.zoom = "";
      if (onPaper && cell.layout.scene && plot._fullLayout) { // 3D is drawn by frames, for which printing does not wait
        plot.style.zoom = plot.parentNode.clientWidth / plot._fullLayout.width;
        return;
      }
      plotly[name].react(plot, cell.traces.map(painted), { ...layout(cell, chart.content.height), ...width }, config);
      plot.querySelectorAll(".main-svg").forEach((svg, layer) => {
        if (layer) return svg.setAttribute("aria-hidden", "true");
        svg.setAttribute("role", "img");
        svg.setAttribute("aria-label", named(chart, cell));
      });
    });
  };

  // The outlines of markers, of Plotly's names: corners at radii in turn, the first at an angle in quarter turns.
  const corners = (count, first, radii = [4], wide = 1) => Array.from({ length: count * radii.length }, (_, k) => {
    const angle = (first + (4 * k) / (count * radii.length)) * (Math.PI / 2), radius = radii[k % radii.length];
    return `${(14 + wide * radius * Math.cos(angle)).toFixed(2)},${(6 + radius * Math.sin(angle)).toFixed(2)}`;
  }).join(" ");
  const outlines = {
    "circle": corners(24, 0, [3.5]), "square": corners(4, 0.5, [4.5]), "diamond": corners(4, 0, [4.5]),
    "diamond-tall": corners(4, 0, [5], 0.6), "triangle-up": corners(3, -1, [4.5]), "triangle-down": corners(3, 1, [4.5]),
    "triangle-left": corners(3, 2, [4.5]), "triangle-right": corners(3, 0, [4.5]), "star": corners(5, -1, [5, 2]),
    "pentagon": corners(5, -1), "hexagon": corners(6, 0), "octagon": corners(8, 0.25),
    "cross": corners(4, 0.5, [1.8, 4.2, 4.2]), "x": corners(4, 0, [1.8, 4.2, 4.2]),
  };
  const swatch = ({ colour, dash, marker }) => {
    const dashes = { solid: "", dash: "6 3", dot: "2 3", dashdot: "6 2 2 2", longdash: "10 3", longdashdot: "10 2 2 2" };
    const line = dash ? `<line x1="1" x2="27" y1="6" y2="6" stroke-width="2" stroke-dasharray="${dashes[dash]}"/>` : "";
    const name = marker.replace("-open", ""), fill = name === marker ? "" : "none";
    const mark = marker && !dash ? `<polygon points="${outlines[name]}" style="fill:${fill}"/>` : "";
    const stroke = colour === "ink" ? "var(--ink)" : colour;
    return `<svg width="28" height="12" aria-hidden="true" style="stroke:${stroke};fill:${stroke}">${line}${mark}</svg>`;
  };
  const legend = chart => {
    const list = document.createElement("div");
    list.className = "legend";
    for (const entry of chart.content.legend) {
      const button = document.createElement("button");
      button.type = "button";
      button.dataset.label = entry.label;
      button.title = "show or hide on the whole page";
      button.innerHTML = swatch(entry);
      button.append(entry.label);
      button.addEventListener("click", () => toggle(entry.label));
      button.setAttribute("aria-pressed", "true");
      list.append(button);
    }
    chart.place.prepend(list);
  };
  const toggle = label => {
    if (!hidden.delete(label)) hidden.add(label);
    for (const button of document.querySelectorAll(".legend button"))
      button.setAttribute("aria-pressed", String(!hidden.has(button.dataset.label)));
    charts.filter(chart => chart.content.legend.some(entry => entry.label === label)).forEach(draw);
  };

  const choice = chart => {
    const cells = chart.content.steps[chart.step];
    if (!chart.content.choice || cells.length < 2) return;
    const label = document.createElement("label"), select = document.createElement("select");
    label.className = "choice";
    for (const cell of cells) select.add(new Option(cell.title));
    label.append(`${chart.content.choice} `, select);
    chart.place.prepend(label);
    select.addEventListener("change", () => {
      chart.chosen = select.selectedIndex;
      draw(chart);
    });
  };

  const slider = chart => {
    const { labels, slider: name, start } = chart.content;
    if (labels.length < 2) return;
    const label = document.createElement("label");
    label.className = "slider";
    chart.input = Object.assign(document.createElement("input"), { type: "range", min: 0, max: labels.length - 1, step: 1, value: start });
    chart.output = document.createElement("output");
    chart.input.setAttribute("aria-label", name || "step");
    label.append(`${name} `, chart.input, chart.output);
    chart.place.prepend(label);
    chart.input.addEventListener("input", () => {
      const same = charts.filter(other => other.input && other.content.slider === name && other.content.labels.length === labels.length);
      same.forEach(other => move(other, Number(chart.input.value)));
    });
  };
  const move = (chart, step) => {
    chart.step = step;
    if (chart.input) {
      chart.input.value = step;
      chart.output.textContent = chart.content.labels[step];
      chart.input.setAttribute("aria-valuetext", chart.content.labels[step]);
    }
    draw(chart);
  };

  const shared = new Set(["x", "y", "z", "surfacecolor", "customdata"]); // a number in their place is that of an array
  for (const place of document.querySelectorAll(".chart")) {
    const content = JSON.parse(place.querySelector("script").textContent);
    for (const trace of content.steps.flat().flatMap(cell => cell.traces))
      for (const key in trace) if (typeof trace[key] === "number" && shared.has(key)) trace[key] = content.arrays[trace[key]];
    place.setAttribute("role", "figure");
    place.setAttribute("aria-label", content.alt || content.name.replaceAll("_", " "));
    const chart = { place, content, step: content.start, chosen: 0, cells: [], titles: [], seen: false };
    const grid = document.createElement("div");
    grid.className = "cells";
    grid.style.setProperty("--columns", content.columns);
    for (const cell of shown(chart)) {
      const figure = document.createElement("div"), title = document.createElement("div"), plot = document.createElement("div");
      title.className = "title";
      plot.className = "plot";
      title.textContent = cell.title;
      plot.style.minHeight = `${content.height}px`;
      figure.append(title, plot);
      grid.append(figure);
      chart.cells.push(plot);
      chart.titles.push(title);
    }
    place.append(grid);
    legend(chart);
    charts.push(chart);
    choice(chart);
    slider(chart);
    move(chart, content.start);
  }
  const seen = new IntersectionObserver(entries => {
    for (const entry of entries.filter(one => one.isIntersecting)) {
      const chart = charts.find(one => one.place === entry.target);
      seen.unobserve(entry.target);
      chart.seen = true;
      setTimeout(() => draw(chart)); // "drawing" is painted first
    }
  }, { rootMargin: "400px" });
  charts.forEach(chart => seen.observe(chart.place));
  // Paper: everything is unfolded, light, as wide as A4, and drawn at once, for printing does not wait.
  addEventListener("beforeprint", () => {
    for (const folded of document.querySelectorAll("details:not([open])")) folded.dataset.folded = folded.open = true;
    root.dataset.paper = "";
    for (const chart of charts) {
      chart.seen ||= shown(chart).every(cell => plotly[bundle(cell)]);
      draw(chart);
    }
  });
  addEventListener("afterprint", () => {
    delete root.dataset.paper;
    for (const opened of document.querySelectorAll("details[data-folded]")) {
      opened.open = false;
      delete opened.dataset.folded;
    }
    redraw();
  });
  // Tables that are wider than their box can be scrolled by keys.
  const boxes = new ResizeObserver(entries => {
    for (const { target: box } of entries) {
      const label = box.querySelector("th").textContent.trim() || "table";
      const given = { tabindex: 0, role: "region", "aria-label": `${label}, scrolls sideways` };
      for (const name in given)
        box.scrollWidth > box.clientWidth ? box.setAttribute(name, given[name]) : box.removeAttribute(name);
    }
  });
  document.querySelectorAll(".wide").forEach(box => boxes.observe(box));
  const redraw = () => charts.forEach(draw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  if (document.getElementById("plotly-heatmap")) needed("heatmap"); // also charts not yet in view may be printed
  root.dataset.explore = "ready";
})();
