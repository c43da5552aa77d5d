"use strict";
const plots = window.Plotly ? [...document.querySelectorAll(".plot")] : [];
for (const plot of plots) {
  const figure = JSON.parse(plot.nextElementSibling.textContent);
  plot.replaceChildren();
  Plotly.newPlot(plot, figure.data, figure.layout, { responsive: true, displaylogo: false });
}
// A4 less its margins is 186 mm wide and 269 mm high, 703 x 1016 px; a caption stands below the plot.
addEventListener("beforeprint", () => {
  for (const plot of plots) {
    plot.dataset.height = plot.style.height;
    plot.style.height = `${Math.min(plot.clientHeight, 920)}px`;
    Plotly.relayout(plot, { autosize: false, width: 700, height: plot.clientHeight });
  }
});
addEventListener("afterprint", () => {
  for (const plot of plots) {
    plot.style.height = plot.dataset.height;
    Plotly.relayout(plot, { autosize: true, width: null, height: null });
  }
});
