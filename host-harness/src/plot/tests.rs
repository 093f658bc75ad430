use super::*;

fn rows() -> Vec<Series<'static>> {
    vec![Series::new("a<b", Ink::Before, Mark::Line, vec![0.0, 1.0, 2.0], vec![5.0, 7.0, 900.0])]
}

fn plot(series: Vec<Series<'_>>) -> Plot<'_> {
    let plot = Plot::new("speed & more", Axis::linear("t", ""), Axis::linear("v", ""));
    Plot { series, ..plot.explained() }
}

#[test]
fn names_are_escaped_and_what_lies_outside_a_range_stretches_no_axis() {
    let mut plot = plot(rows());
    assert!(plot.svg().contains("800"));
    plot.x = plot.x.within([0.0, 1.0]);
    let svg = plot.svg();
    assert!(svg.contains("a&lt;b") && !svg.contains("a<b") && svg.contains("speed &amp; more"));
    assert!(!svg.contains("800") && !svg.contains("NaN") && !svg.contains("inf"));
}

#[test]
fn a_plot_of_nothing_is_nothing_and_a_point_alone_is_drawn() {
    let of =
        |y: Vec<f64>| plot(vec![Series::new("", Ink::Text, Mark::Line, vec![0.0, 1.0], y)]).svg();
    assert_eq!(of(vec![f64::NAN, f64::INFINITY]), "");
    assert!(of(vec![f64::NAN, 0.0]).contains("class=\"dot\""));
}

#[test]
fn what_is_not_above_zero_has_no_place_on_a_logarithmic_axis() {
    let values = vec![0.0, 1.0, 10.0];
    let series = Series::new("", Ink::Nth(9), Mark::Dots, vec![1.0, 2.0, 3.0], values);
    let plot = Plot { y: Axis::log("error", "%"), ..plot(vec![series]) };
    let svg = plot.svg();
    assert_eq!(svg.matches("h0").count(), 2, "{svg}");
    assert!(svg.contains("nth1") && !svg.contains("NaN") && !svg.contains("inf"));
}

#[test]
fn every_mark_draws_each_of_its_points() {
    let (x, y) = (vec![0.0, 1.0, 2.0, 3.0], vec![1.0, 2.0, 4.0, 2.0]);
    for (mark, sign, count) in [
        (Mark::Line, "L", 3),
        (Mark::Dots, "h0", 4),
        (Mark::Rings, "h0", 8),
        (Mark::Points, "h0", 4),
        (Mark::Bars, "L", 4),
        (Mark::Levels, "L", 4),
        (Mark::Uprights, "L", 4),
        (Mark::Links, "L", 2),
    ] {
        let series = Series::new("", Ink::After, mark, &x, &y);
        let svg = Plot { legend: false, ..plot(vec![series]) }.svg();
        let (_, field) = svg.split_once("class=\"field\"").unwrap();
        let (field, _) = field.split_once("</svg>").unwrap();
        assert_eq!(field.matches(sign).count(), count, "{mark:?}");
    }
    let high = y.iter().map(|value| value + 1.0).collect();
    let svg = plot(vec![Series::band("", Ink::After, &x, [y, high])]).svg();
    assert!(svg.contains("class=\"area\""));
}

#[test]
fn a_picture_is_well_formed_and_as_high_as_its_plots() {
    let (one, two) = (picture(&[plot(rows())]), picture(&[plot(rows()), plot(rows())]));
    let height = |svg: &str| -> f64 {
        let (_, rest) = svg.split_once("height=\"").unwrap();
        rest.split_once('"').unwrap().0.parse().unwrap()
    };
    assert!(height(&two) > 2.0 * height(&one));
    // Every tag is closed, and every attribute quoted, as a file of its own asks for.
    assert_eq!(two.matches("<svg").count(), two.matches("</svg>").count());
    assert_eq!(two.matches("<g").count(), two.matches("</g>").count());
    for tag in two.split('<').skip(1).filter(|tag| !tag.starts_with('/')) {
        let (tag, _) = tag.split_once('>').unwrap();
        assert_eq!(tag.matches('=').count() * 2, tag.matches('"').count(), "{tag}");
    }
}

#[test]
fn a_page_loads_nothing_from_elsewhere() {
    let page = page("<title>", &plot(rows()).svg());
    assert!(page.contains("<title>&lt;title&gt;</title>"));
    for link in ["src=", "href=", "@import", "url("] {
        assert!(!page.contains(link), "{link}");
    }
}
