use super::plot::escape;
use super::publish::{Chapter, encoded};
use super::run::{Studied, Study};
use super::strip::Strip;
use super::verdict::{digits, time};
use super::{Curve, machine};
use crate::batch::StageSeconds;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// The report: one HTML file with everything in it, that needs no network.
pub(super) fn html(study: &Study, studied: &Studied, chapters: &[Chapter]) -> Result<String, String> {
    let mut body = String::new();
    for (number, chapter) in chapters.iter().enumerate() {
        body += &section(number, chapter)?;
    }
    let size = study.jobs.first().map(|j| (j.settings.views.width, j.settings.views.height)).unwrap_or_default();
    let assets = if chapters.len() == 1 { "1 asset".into() } else { format!("{} assets", chapters.len()) };
    let unfinished = if studied.interrupted {
        "<p class=\"warn\">This study was interrupted. The same command goes on where it was.</p>\n"
    } else {
        ""
    };
    Ok(format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>What accuracy costs in time</title>\n<style>\n{}</style>\n</head>\n<body>\n\
         <header>\n<h1>What accuracy costs in time</h1>\n\
         <p class=\"meta\">kiln {}, {assets}, pictures of {} × {} pixels, {} ways, {} seeds; {}</p>\n{unfinished}{}</header>\n\
         <main>\n{body}</main>\n<footer>\n{}</footer>\n</body>\n</html>\n",
        include_str!("report.css"),
        env!("CARGO_PKG_VERSION"),
        size.0,
        size.1,
        study.ways.len(),
        study.seeds,
        escape(&machine()),
        contents(chapters),
        METHOD,
    ))
}

const METHOD: &str = "\
<h3>How it was measured</h3>
<p>Each way renders the same view with growing numbers of samples per pixel and several seeds. <b>Error</b> is the root
mean square difference from the reference as displayed (tone-mapped, sRGB, levels 0–255, before rounding) over the pixels
that the asset covers; the reference’s own error, estimated from its own samples, is taken off. <b>relMSE</b> is
the relative mean square error in linear light, <b>FLIP</b> (Andersson 2020, 67 pixels per degree) the difference that a
person sees when flipping between two pictures: 0.10 is just noticeable, and an error counts as invisible when 95 % of the
covered pixels are below that.</p>
<p><b>Seconds</b> are CPU seconds of all threads together, from reading the asset to encoding the picture. <b>Bias</b> is the
difference of the mean brightness from the reference’s, with its 95 % confidence interval. Where it is significant at 1 %
over all ways of the study (Šidák), a way that leaves something out is biased, and any other has not settled yet: light
that is found rarely does not show in the spread either. A way is <b>efficient</b> when no other gives less error in less
time. The <b>slope</b> is that of log error against log time: −0.5 for independent samples, steeper for well distributed
ones; half the error costs 2<sup>−1/slope</sup> times the time.</p>
<p>cells.csv and study.json beside this file hold every figure.</p>
";

fn contents(chapters: &[Chapter]) -> String {
    if chapters.len() < 2 {
        return String::new();
    }
    let links: Vec<String> = chapters
        .iter()
        .enumerate()
        .map(|(i, c)| format!("<a href=\"#asset-{i}\">{}</a>", escape(&c.subject.name)))
        .collect();
    format!("<nav aria-label=\"Assets\"><p>{}</p></nav>\n", links.join(" · "))
}

fn section(number: usize, chapter: &Chapter) -> Result<String, String> {
    let subject = chapter.subject;
    let name = escape(&subject.name);
    let outcome = &subject.outcome;
    let Some(verdict) = &chapter.verdict else {
        let why = outcome.error_message.as_deref().unwrap_or("nothing was measured");
        return Ok(format!(
            "<section id=\"asset-{number}\">\n<h2>{name}</h2>\n<p class=\"verdict\">{}</p>\n</section>\n",
            escape(why)
        ));
    };
    let triangles = outcome.scene.as_ref().map_or(0, |s| s.triangles);
    let light = outcome.light.as_deref().unwrap_or("none");
    let reference = subject.reference.as_ref().map_or(String::new(), |r| {
        let (spp, error) = (r.facts.spp, digits(r.facts.error));
        format!("; the reference has {spp} samples per pixel and an error of {error} levels of its own")
    });
    let [rmse, relmse, flip] = chapter.plots.each_ref().map(|(_, plot)| plot.to_svg());
    Ok(format!(
        "<section id=\"asset-{number}\">\n<h2>{name}</h2>\n\
         <p class=\"meta\">{triangles} triangles, lit by: {}{reference}</p>\n\
         <p class=\"verdict\">{}</p>\n\
         <h3>What samples look like, and their price</h3>\n{}\
         <h3>Error against time</h3>\n<div class=\"figure\">{rmse}</div>\n{}\
         <h3>What each way gives in about the same time</h3>\n{}\
         <details>\n<summary>FLIP and relMSE against time</summary>\n<div class=\"figure\">{flip}</div>\n\
         <div class=\"figure\">{relmse}</div>\n</details>\n\
         <details>\n<summary>All figures, and seconds by stage</summary>\n{}{}</details>\n</section>\n",
        escape(light),
        escape(&verdict.text),
        pictures(&chapter.samples, &subject.name)?,
        ways_table(chapter),
        pictures(&chapter.ways, &subject.name)?,
        points_table(chapter),
        stages_table(&chapter.analysis.curves),
    ))
}

fn pictures(strip: &Strip, asset: &str) -> Result<String, String> {
    let mut items = String::new();
    for frame in &strip.frames {
        let data = STANDARD.encode(encoded(frame.width, &frame.pixels)?);
        let [what, price, error] = frame.caption.each_ref().map(|line| escape(&line.replace("+-", "±")));
        items += &format!(
            "<li><figure><img alt=\"{} with {what}: {error} of error in {price}\" src=\"data:image/png;base64,{data}\">\
             <figcaption><strong>{what}</strong>{price} · {error}</figcaption></figure></li>\n",
            escape(asset)
        );
    }
    Ok(format!("<ul class=\"strip\">\n{items}</ul>\n"))
}

fn table(caption: &str, head: &[&str], rows: &[Vec<String>]) -> String {
    let head: String = head.iter().map(|h| format!("<th scope=\"col\">{h}</th>")).collect();
    let row = |cells: &Vec<String>| {
        let mut cells = cells.iter();
        let first = cells.next().map_or(String::new(), |c| format!("<th scope=\"row\">{c}</th>"));
        let rest: String = cells.map(|c| format!("<td>{c}</td>")).collect();
        format!("<tr>{first}{rest}</tr>\n")
    };
    let rows: String = rows.iter().map(row).collect();
    format!(
        "<div class=\"scroll\"><table>\n<caption>{caption}</caption>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n\
         </table></div>\n"
    )
}

fn ways_table(chapter: &Chapter) -> String {
    let analysis = &chapter.analysis;
    let rows: Vec<Vec<String>> = analysis
        .curves
        .iter()
        .map(|curve| {
            let last = curve.points.last();
            let times = curve.versus.map_or("–".into(), |v| {
                let more = if v.at_least { "&gt; " } else { "" };
                format!("{more}{:.2}× <span class=\"words\">at {} levels</span>", v.ratio(), digits(v.error))
            });
            let bias = curve.bias.map_or("–".into(), |b| {
                let text = format!("{:+.2} ± {:.2} %", 100.0 * b.relative, 100.0 * b.half_width);
                if curve.biased || curve.unsettled { format!("<span class=\"warn\">{text}</span>") } else { text }
            });
            vec![
                format!("{}<br><span class=\"words\">{}</span>", escape(&curve.way), escape(&curve.title)),
                times,
                curve.slope.map_or("–".into(), |s| format!("{s:.2}")),
                last.map_or("–".into(), |p| format!("{} in {}", digits(p.error), time(p.cpu_seconds.total))),
                bias,
            ]
        })
        .collect();
    let caption = "The ways compared; time is that for the same error, and a bias in bold is significant";
    let head = ["Way", "Time against the first", "Slope", "Least error", "Bias"];
    table(caption, &head, &rows)
}

fn points_table(chapter: &Chapter) -> String {
    let analysis = &chapter.analysis;
    let mut rows = Vec::new();
    for (c, curve) in analysis.curves.iter().enumerate() {
        for (p, point) in curve.points.iter().enumerate() {
            let limited = if point.limited { " (the reference limits it)" } else { "" };
            rows.push(vec![
                format!("{}, {}", escape(&curve.way), point.spp),
                format!("{}{limited}", digits(point.error)),
                format!("{} … {}", digits(point.range[0]), digits(point.range[1])),
                digits(point.relmse),
                digits(point.flip),
                digits(point.flip_p95),
                time(point.cpu_seconds.total),
                time(point.seconds.total),
                if analysis.frontier.contains(&(c, p)) { "yes" } else { "" }.into(),
            ]);
        }
    }
    let head = ["Way, samples", "Error", "As measured", "relMSE", "FLIP", "FLIP 95 %", "CPU", "Wall", "Efficient"];
    table("Means over the seeds", &head, &rows)
}

fn stages_table(curves: &[Curve]) -> String {
    let cells = |s: &StageSeconds| [s.import, s.prepare, s.kdtree, s.render, s.write, s.total].map(time);
    let rows: Vec<Vec<String>> = curves
        .iter()
        .filter_map(|c| Some((c, c.points.last()?)))
        .map(|(c, p)| {
            let mut row = vec![format!("{}, {}", escape(&c.way), p.spp)];
            row.extend(cells(&p.cpu_seconds));
            row.push(time(p.seconds.total));
            row
        })
        .collect();
    let head = ["Way, samples", "Import", "Prepare", "kd-tree", "Render", "Write", "CPU in all", "Wall in all"];
    table("CPU seconds by stage, at the most samples", &head, &rows)
}
