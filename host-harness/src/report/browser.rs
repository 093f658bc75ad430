//! The pages as a browser has them: drawn, zoomed and without overflow. Skipped by name where there is no Chromium.

use std::process::Command;

use super::html;
use super::tests::{findings, log, source, without_a_name};
use crate::discover::findings::Answer;
use crate::plot::{self, Axis, Ink, Mark, Plot, Series};

/// Collects what goes wrong, before anything else runs.
const WATCH: &str = "<script>window.wrong=[];addEventListener('error',e=>wrong.push(e.message));\
                     const own=console.error;console.error=(...a)=>{wrong.push(a.join(' '));own(...a)};</script>";

/// Tries the page as a person would, and tells the frame around it what it found.
const TRY: &str = r#"<script>addEventListener('load',()=>{
  const told = [];
  const claim = (name, holds) => { if (!holds) told.push(name); };
  const plots = [...document.querySelectorAll('.panel > svg.plot')];
  claim('plots are there', plots.length >= +document.body.dataset.least);
  claim('every plot is drawn', plots.every(plot => [...plot.querySelectorAll('.field path')]
    .some(path => (path.getAttribute('d') || '').length > 3)));
  claim('the window is as narrow as asked', innerWidth === +document.body.dataset.width);
  claim('nothing is wider than the screen',
    document.scrollingElement.scrollWidth <= document.documentElement.clientWidth);
  claim('no table is wider than its page',
    [...document.querySelectorAll('.wide')].every(own => own.scrollWidth <= own.clientWidth + 1));
  const beside = [...document.querySelectorAll('.field text')];
  claim('a dot has its name', !beside.length || beside.some(own => getComputedStyle(own).visibility === 'visible'));
  for (const plot of plots) {
    const sheet = plot.getBoundingClientRect();
    const texts = [...plot.querySelectorAll('text')].filter(own => getComputedStyle(own).visibility === 'visible')
      .map(own => [own.textContent, own.getBoundingClientRect()]);
    for (const [text, box] of texts) {
      claim(`${text} is whole`, box.left > sheet.left - 1 && box.right < sheet.right + 1
        && box.top > sheet.top - 1 && box.bottom < sheet.bottom + 1);
    }
    // Lines of text share the blank above and below their letters.
    texts.forEach(([text, one], k) => texts.slice(0, k).forEach(([before, other]) => claim(`${text} leaves ${before} free`,
      Math.min(one.right, other.right) - Math.max(one.left, other.left) < 1
      || Math.min(one.bottom, other.bottom) - Math.max(one.top, other.top) < 4)));
  }
  const linked = plots.filter(plot => plot.dataset.link === 'time');
  const seen = plot => plot.querySelector('.field').getAttribute('viewBox').split(' ').map(Number);
  const width = plot => +plot.dataset.wide;
  plots.forEach(plot => { plot.dataset.wide = seen(plot)[2]; });
  const send = (plot, type, share, id, kind) => {
    const box = plot.querySelector('.frame').getBoundingClientRect();
    plot.dispatchEvent(new PointerEvent(type, {pointerId: id, pointerType: kind, button: 0, bubbles: true,
      clientX: box.left + share * box.width, clientY: box.top + box.height / 2}));
  };
  if (linked.length > 1) {
    const [one, other] = linked;
    send(one, 'pointerdown', 0.25, 1, 'mouse');
    send(one, 'pointermove', 0.40, 1, 'mouse');
    send(one, 'pointerup', 0.50, 1, 'mouse');
    const [x, w] = [seen(one)[0], seen(one)[2]];
    claim('a drag chooses its part', Math.abs(w / width(one) - 0.25) < 0.01
      && Math.abs(x / width(one) - 0.25) < 0.01);
    claim('a plot over time beside it follows', Math.abs(seen(other)[2] / width(other) - 0.25) < 0.01);
    claim('the readout tells numbers', /at .*: .*[0-9]/.test(
      one.parentNode.querySelector('.hover').textContent));
    const reset = one.parentNode.querySelector('.reset');
    claim('the button is there', !reset.hidden);
    reset.click();
    claim('the button shows all of it', linked.every(plot => Math.abs(seen(plot)[2] - width(plot)) < 0.01));
    send(one, 'pointerdown', 0.4, 2, 'touch');
    send(one, 'pointerdown', 0.6, 3, 'touch');
    send(one, 'pointermove', 0.3, 2, 'touch');
    send(one, 'pointermove', 0.7, 3, 'touch');
    claim('two fingers zoom', Math.abs(seen(one)[2] / width(one) - 0.5) < 0.02);
    send(one, 'pointerup', 0.3, 2, 'touch');
    send(one, 'pointerup', 0.7, 3, 'touch');
    one.dispatchEvent(new MouseEvent('dblclick', {bubbles: true}));
    claim('a double click shows all of it', Math.abs(seen(one)[2] - width(one)) < 0.01);
  }
  parent.postMessage([...told, ...wrong].join('; ') || 'all holds', '*');
});</script>"#;

/// What the page says of itself in a window of this width; `None` without a browser.
fn tried(page: &str, width: u32, least: usize) -> Option<String> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let chromium = names.into_iter().find(|name| {
        Command::new(name).arg("--version").output().is_ok_and(|told| told.status.success())
    })?;
    let folder = tempfile::tempdir().unwrap();
    let page = page.replacen("<head>", &format!("<head>{WATCH}"), 1);
    let page = page.replacen(
        "<body>",
        &format!("<body data-least=\"{least}\" data-width=\"{width}\">"),
        1,
    );
    let page = page.replacen("</body>", &format!("{TRY}</body>"), 1);
    std::fs::write(folder.path().join("report.html"), page).unwrap();
    // A window may be no narrower than a browser likes; a frame may.
    let file = folder.path().join("frame.html");
    let frame = format!(
        "<!doctype html><body><iframe style=\"width:{width}px;height:2000px;border:0\" src=\"report.html\">\
         </iframe><script>addEventListener('message',e=>{{document.body.dataset.told=e.data}})</script>"
    );
    std::fs::write(&file, frame).unwrap();
    let told = Command::new(chromium)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
        .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
        .args(["--window-size=1400,2000", "--virtual-time-budget=5000", "--dump-dom"])
        .arg(format!("file://{}", file.display()))
        .output()
        .unwrap();
    let dom = String::from_utf8_lossy(&told.stdout).into_owned();
    let (_, told) = dom.split_once("data-told=\"")?;
    Some(told.split_once('"')?.0.to_owned())
}

#[test]
fn a_browser_draws_every_page_zooms_it_and_needs_no_sideways_scroll() {
    let log = log();
    let pages = [
        (findings(10_000), 10),
        (without_a_name(Answer::Unknown), 10),
        (without_a_name(Answer::Adequate), 10),
        (without_a_name(Answer::Undecided), 3),
    ];
    for (findings, least) in &pages {
        let page = html(findings, std::slice::from_ref(&log), &source());
        for width in [1280, 390] {
            let Some(told) = tried(&page, width, *least) else {
                eprintln!("skipped: a_browser_draws_every_page (no Chromium on the path)");
                return;
            };
            assert_eq!(told, "all holds", "{:?} at {width} pixels", findings.verdict.verdict);
        }
    }
}

/// Dots that crowd, one at the edge, over thirteen powers of ten, above a written end of an axis.
fn crowded() -> String {
    let across = vec![1.0, 1.02, 1.04, 5.0];
    let labels = ["0.250 µs", "0.100 µs", "0.050 µs", "0.025 µs"].map(str::to_owned).to_vec();
    let up = vec![1e-8, 1.1e-8, 1.2e-8, 1e5];
    let series = Series { labels, ..Series::new("step", Ink::Nth(0), Mark::Dots, across, up) };
    let marked = vec![(1.0, "1 (forced)".to_owned()), (5.0, "5 (chosen)".to_owned())];
    let plot = Plot::new(
        "Crowded",
        Axis::log("micro-steps", "").marked(marked).within([0.9, 5.0]),
        Axis::log("worst relative RMS error of a state", "%"),
    );
    let plot = Plot { series: vec![series], ..plot.sized(560.0, 240.0).explained() };
    plot::page("Crowded", &plot.svg())
}

#[test]
fn a_browser_draws_every_label_whole_and_none_over_another() {
    for width in [1280, 390] {
        let Some(told) = tried(&crowded(), width, 1) else {
            eprintln!("skipped: a_browser_draws_every_label (no Chromium on the path)");
            return;
        };
        assert_eq!(told, "all holds", "at {width} pixels");
    }
}
