use super::*;
use crate::describe::{RandomDesc, Source};

const FRAMES: usize = 10_000;

/// The draws of a distribution at so many frames, in TOML.
fn texts(distribution: &str) -> Vec<String> {
    let source = Source::new("r.toml".into(), format!("\"a.b\" = {distribution}\n"));
    let random = RandomDesc::of_source(&source).unwrap_or_else(|e| panic!("{e}"));
    let (distribution, key) = (&random.draws[0].distribution, DrawKey::new(3, "scene", "a.b"));
    (1..=FRAMES as i64).map(|frame| distribution.draw(key, frame)).collect()
}

fn numbers(distribution: &str) -> Vec<f64> {
    let texts = texts(distribution);
    texts.iter().map(|text| text.parse().expect("a number")).collect()
}

fn lists(distribution: &str) -> Vec<[f64; 3]> {
    let list = |text: &String| {
        let value: toml::Value = text.parse().expect("a list");
        let numbers = value.as_array().expect("a list").iter();
        let numbers: Vec<f64> = numbers.map(|v| v.as_float().expect("a number")).collect();
        numbers.try_into().expect("three numbers")
    };
    texts(distribution).iter().map(list).collect()
}

/// Checks by the test of Kolmogorov and Smirnov that numbers have this cumulative distribution. By chance
/// alone, one set in 10^5 would fail.
fn check(mut numbers: Vec<f64>, cumulative: impl Fn(f64) -> f64) {
    numbers.sort_by(f64::total_cmp);
    let count = numbers.len() as f64;
    let away = numbers.iter().enumerate().map(|(i, v)| {
        let expected = cumulative(*v);
        f64::max(expected - i as f64 / count, (i + 1) as f64 / count - expected)
    });
    let worst = away.fold(0.0, f64::max);
    assert!(worst < 2.47 / count.sqrt(), "{worst}");
}

/// Checks that counts are those of these probabilities by Pearson's sum, which has a variance of twice its mean.
fn check_counts(counts: &[usize], probabilities: &[f64]) {
    let total: usize = counts.iter().sum();
    let terms = counts.iter().zip(probabilities).map(|(found, p)| {
        let expected = p * total as f64;
        (*found as f64 - expected).powi(2) / expected
    });
    let (sum, freedom) = (terms.sum::<f64>(), counts.len() as f64 - 1.0);
    assert!(sum < freedom + 5.0 * (2.0 * freedom).sqrt(), "{sum}: {counts:?}");
}

fn moments(numbers: &[f64]) -> [f64; 2] {
    let count = numbers.len() as f64;
    let mean = numbers.iter().sum::<f64>() / count;
    [mean, numbers.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count]
}

#[test]
fn a_range_is_drawn_evenly() {
    let drawn = numbers("[1, 10]");
    let [mean, variance] = moments(&drawn);
    // The standard errors are 0.026 and 0.06.
    assert!((mean - 5.5).abs() < 0.12, "{mean}");
    assert!((variance - 6.75).abs() < 0.3, "{variance}");
    check(drawn, |v| (v - 1.0) / 9.0);
    check(numbers("{ uniform = [-3, 5] }"), |v| (v + 3.0) / 8.0);
    assert!(numbers("[2, 2]").iter().all(|v| *v == 2.0));
}

#[test]
fn a_test_of_evenness_finds_a_bias_of_five_percent() {
    let drawn = numbers("[0, 1]").into_iter().map(|v| libm::pow(v, 1.1)).collect();
    assert!(std::panic::catch_unwind(|| check(drawn, |v| v)).is_err());
}

#[test]
fn neighbouring_frames_and_names_are_not_correlated() {
    let drawn = numbers("[0, 1]");
    let other = DrawKey::new(3, "scene", "a.c");
    let law = Distribution::Number(Law::Uniform([0.0, 1.0]));
    let others: Vec<f64> = (1..=FRAMES as i64)
        .map(|frame| law.draw(other, frame).parse().expect("a number"))
        .collect();
    let correlation = |a: &[f64], b: &[f64]| {
        let product = a.iter().zip(b).map(|(a, b)| (a - 0.5) * (b - 0.5));
        12.0 * product.sum::<f64>() / a.len() as f64
    };
    for (a, b) in [
        (&drawn[..], &others[..]),
        (&drawn[1..], &drawn[..FRAMES - 1]),
        (&drawn[2..], &drawn[..FRAMES - 2]),
    ] {
        let found = correlation(a, b);
        assert!(found.abs() < 0.05, "{found}");
    }
}

#[test]
fn the_numbers_of_a_list_are_drawn_each_by_itself() {
    let drawn = lists("[[0, 0, 1], [1, 2, 1]]");
    check(drawn.iter().map(|v| v[0]).collect(), |v| v);
    check(drawn.iter().map(|v| v[1]).collect(), |v| v / 2.0);
    let product: f64 = drawn.iter().map(|v| (v[0] - 0.5) * (v[1] - 1.0)).sum();
    assert!((6.0 * product / FRAMES as f64).abs() < 0.05);
    assert!(drawn.iter().all(|v| v[2] == 1.0));
    let drawn = lists("{ log = [[1, 1, 1], [10, 100, 1000]] }");
    check(drawn.iter().map(|v| v[2]).collect(), |v| v.log10() / 3.0);
}

#[test]
fn the_logarithm_of_a_logarithmic_range_is_uniform() {
    let drawn = numbers("{ log = [0.5, 500] }");
    assert!(drawn.iter().all(|v| (0.5..=500.0).contains(v)));
    check(drawn, |v| (v / 0.5).log10() / 3.0);
}

#[test]
fn a_normal_distribution_has_its_mean_deviation_and_shape() {
    let below = |z: f64| 0.5 * libm::erfc(-z / SQRT_2);
    let drawn = numbers("{ normal = [5, 1.5] }");
    let [mean, variance] = moments(&drawn);
    assert!((mean - 5.0).abs() < 0.07, "{mean}");
    assert!((variance.sqrt() - 1.5).abs() < 0.05, "{variance}");
    check(drawn, |v| below((v - 5.0) / 1.5));
    // The part that lies within, and nothing at its ends.
    let drawn = numbers("{ normal = [5, 1.5], min = 6, max = 9 }");
    assert!(drawn.iter().all(|v| *v > 6.0 && *v < 9.0));
    let [from, to] = [6.0, 9.0].map(|v| below((v - 5.0) / 1.5));
    check(drawn, |v| (below((v - 5.0) / 1.5) - from) / (to - from));
}

#[test]
fn whole_numbers_have_both_ends_and_are_equally_likely() {
    let drawn = texts("{ integer = [-1, 4] }");
    let counts: Vec<usize> = (-1..=4)
        .map(|n: i64| drawn.iter().filter(|text| **text == n.to_string()).count())
        .collect();
    assert_eq!(counts.iter().sum::<usize>(), FRAMES);
    check_counts(&counts, &[1.0 / 6.0; 6]);
}

#[test]
fn choices_are_as_likely_as_their_weights() {
    let count = |drawn: &[String], options: &[&str]| -> Vec<usize> {
        let of = |option: &&str| drawn.iter().filter(|text| *text == option).count();
        options.iter().map(of).collect()
    };
    let drawn = texts("[\"red\", \"blue\", \"green\"]");
    check_counts(&count(&drawn, &["\"red\"", "\"blue\"", "\"green\""]), &[1.0 / 3.0; 3]);
    let drawn = texts("[true, false]");
    check_counts(&count(&drawn, &["true", "false"]), &[0.5; 2]);
    let drawn = texts("{ choice = [1, 2.5, [0, 1, 0], \"a\"], weights = [1, 0, 2, 5] }");
    let counts = count(&drawn, &["1", "[0, 1, 0]", "\"a\"", "2.5"]);
    assert_eq!(counts[3], 0);
    check_counts(&counts[..3], &[0.125, 0.25, 0.625]);
}

#[test]
fn points_of_a_sphere_are_uniform_in_direction_and_distance() {
    let drawn = lists("{ sphere = 2, center = [1, 2, 3] }");
    let offsets: Vec<[f64; 3]> = drawn.iter().map(|v| [v[0] - 1.0, v[1] - 2.0, v[2] - 3.0]).collect();
    let length = |v: &[f64; 3]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
    assert!(offsets.iter().all(|v| (length(v) - 2.0).abs() < 1e-12));
    // By Archimedes, each coordinate of a uniform point of a sphere is uniform.
    for axis in 0..3 {
        check(offsets.iter().map(|v| v[axis]).collect(), |v| (v + 2.0) / 4.0);
    }
    let drawn = lists("{ sphere = [2, 4], upper = true }");
    check(drawn.iter().map(length).collect(), |v| (v - 2.0) / 2.0);
    check(drawn.iter().map(|v| v[1] / length(v)).collect(), |v| v);
    let turn = |v: &[f64; 3]| libm::atan2(v[0], v[2]) / std::f64::consts::TAU + 0.5;
    check(drawn.iter().map(turn).collect(), |v| v);
}

#[test]
fn draws_of_a_fixed_address_are_constants_on_every_machine() {
    let draw = |(distribution, frame): (&str, usize)| texts(distribution)[frame - 1].clone();
    let drawn = [
        ("[0, 1]", 1),
        ("{ normal = [0, 1] }", 2),
        ("{ log = [1, 10] }", 3),
        ("{ sphere = 1 }", 4),
        ("{ integer = [1, 1000000] }", 10_000),
    ];
    let expected = [
        "0.656841678462959",
        "-0.657410299704627",
        "2.0572180538759186",
        "[0.6560465400720666, -0.04140578819862495, -0.7535837697052139]",
        "422399",
    ];
    assert_eq!(drawn.map(draw), expected);
}
