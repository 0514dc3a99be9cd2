use super::*;
use crate::describe::{Overrides, SceneDesc, ValueSource, Values, parse};

fn read(text: &str) -> Result<RandomDesc, String> {
    RandomDesc::of_source(&Source::new("r.toml".into(), text)).map_err(|e| e.to_string())
}

fn names(random: &RandomDesc) -> Vec<&str> {
    random.draws.iter().map(|draw| draw.name.as_str()).collect()
}

#[test]
fn a_name_may_be_in_one_piece_or_in_tables() {
    let one = read("seed = 3\n\"light.key.point.intensity\" = [1, 10]\n").expect("a table");
    let spread = read("seed = 3\nlight.key.point.intensity = [1, 10]\n").expect("a table");
    let headed =
        read("[random]\nseed = 3\n[random.light.key]\npoint.intensity = { uniform = [1, 10] }\n").expect("a table");
    for random in [&one, &spread, &headed] {
        assert_eq!(random.seed, 3);
        assert_eq!(names(random), ["light.key.point.intensity"]);
        assert_eq!(random.draws[0].distribution, one.draws[0].distribution);
    }
    assert_eq!(headed.draws[0].origin, "r.toml:4");
    // Words that are distributions elsewhere are names of objects and kinds here.
    let names_of_kinds = read("object.sphere.shape.sphere.radius = [1, 2]\nobject.log.visible = [true, false]\n");
    assert_eq!(
        names(&names_of_kinds.expect("a table")),
        ["object.log.visible", "object.sphere.shape.sphere.radius"]
    );
}

#[test]
fn flags_win_over_the_file_in_whichever_form_it_has_a_name() {
    let flags = Overrides::default()
        .with("random.seed", 9)
        .with("random.light.key.point.intensity", toml::Value::from(vec![5, 6]))
        .with("random.material.m.matte.albedo", toml::Value::from(vec![0, 1]));
    for text in [
        "seed = 3\n\"light.key.point.intensity\" = [1, 10]\n",
        "light.key.point.intensity = [1, 10]\n",
        "light.key.point.intensity = { log = [1, 10] }\n",
    ] {
        let source = Source::new("r.toml".into(), text).with(flags.clone());
        let random = RandomDesc::of_source(&source).unwrap_or_else(|e| panic!("{e}"));
        let expected = read("\"light.key.point.intensity\" = [5, 6]\n").expect("a table");
        let found = random.draws.iter().find(|draw| draw.name.starts_with("light"));
        assert_eq!(found.expect("a light").distribution, expected.draws[0].distribution);
        assert_eq!((random.seed, random.draws.len()), (9, 2), "{text}");
    }
}

#[test]
fn tables_that_are_wrong_are_refused_with_the_line_and_what_is_wrong() {
    for (value, message) in [
        ("[nan, 1]", "expected a finite number"),
        ("[1, inf]", "expected a finite number"),
        ("[1, 1e300]", "too large"),
        ("[10, 1]", "a range rises, and does not fall from 10 to 1"),
        ("[]", "there is nothing to choose from"),
        ("[1, 2, 3]", "a list is a range of two numbers, or names to choose from"),
        ("[1, \"a\"]", "a list is a range of two numbers"),
        ("[[0, 1], [1, 1, 1]]", "two lists of as many numbers are expected"),
        ("[[], []]", "two lists of as many numbers are expected"),
        ("5", "expected a distribution, found one number"),
        ("\"red\"", "expected a distribution, found the text \"red\""),
        ("{ log = [0, 10] }", "lies above 0"),
        ("{ log = [-1, 10] }", "lies above 0"),
        ("{ log = 3 }", "expected an array of length 2"),
        (
            "{ normal = [1, 0] }",
            "the deviation of a normal distribution is above 0",
        ),
        (
            "{ normal = [1, -2] }",
            "the deviation of a normal distribution is above 0",
        ),
        ("{ normal = [1, nan] }", "expected a finite number"),
        ("{ normal = [1, 1], min = 3, max = 2 }", "lies above `max`"),
        ("{ normal = [1, 1], min = 90 }", "less than 1 % of the distribution"),
        ("{ integer = [1.5, 2] }", "expected a whole number, found `1.5`"),
        ("{ integer = [6, 1] }", "does not fall from 6 to 1"),
        ("{ integer = [0, 9223372036854775807] }", "too large"),
        ("{ choice = [] }", "there is nothing to choose from"),
        ("{ choice = 3 }", "expected a list to choose from"),
        ("{ choice = [1, 2], weights = [1] }", "there is 1 weight for 2 values"),
        ("{ choice = [1], weights = [1, 2] }", "there are 2 weights for 1 value"),
        ("{ choice = [1, nan] }", "expected a finite number"),
        ("{ normal = [1, 1], min = nan }", "expected a finite number"),
        ("{ sphere = nan }", "expected a finite number"),
        ("{ sphere = inf }", "expected a finite number"),
        ("{ choice = [1, 2], weights = [1, -1] }", "a weight is at least 0"),
        (
            "{ choice = [1, 2], weights = [0, 0] }",
            "one weight at least is above 0",
        ),
        ("{ choice = [1, { a = 1 }] }", "a table cannot be chosen"),
        ("{ choice = [1979-05-27] }", "a date cannot be chosen"),
        ("{ sphere = -1 }", "a radius is above 0"),
        ("{ sphere = 0 }", "a radius is above 0"),
        ("{ sphere = [2, 1] }", "does not fall from 2 to 1"),
        ("{ sphere = 1, center = [0, 0] }", "expected an array of length 3"),
        ("{ sphere = 1, upper = 1 }", "expected a boolean"),
        ("{ unifrom = [1, 2] }", "this distribution has no kind"),
        ("{ uniform = [1, 2], log = [1, 2] }", "not `uniform` and `log`"),
        ("{ uniform = [1, 2], min = 0 }", "unknown key `min`"),
        ("{ normal = [1, 2], mim = 0 }", "did you mean `min`"),
    ] {
        let text = format!("seed = 1\n\"light.key.point.intensity\" = {value}\n");
        let found = read(&text).map(drop).expect_err(value);
        assert!(
            found.contains(message) && found.contains("r.toml:2:"),
            "{value}: {found}"
        );
    }
    for (text, message) in [
        ("seed = -1\n", "a seed is a whole number from 0"),
        ("seed = 1.5\n", "expected a whole number, found `1.5`"),
        ("scene = 1\n", "expected a string"),
        ("light = {}\n", "there is no distribution"),
        ("light.a = [1, 2]\n\"light.a\" = [1, 2]\n", "`light.a` is drawn twice"),
        ("light.a = [1, 2\n", "r.toml:1:"),
    ] {
        let found = read(text).map(drop).expect_err(text);
        assert!(found.contains(message), "{text}: {found}");
    }
}

const SCENE: &str = "[camera.perspective]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n\
                     [material.m]\nmatte = { albedo = 0.5 }\n\
                     [[object]]\nname = 'ball'\nmaterial = 'm'\nshape.sphere = { radius = 1 }\n\
                     [[light]]\nname = 'key'\npoint = { position = [0, 1, 2], intensity = 3 }\n[random]\n";

fn scene(random: &str, overrides: &Overrides) -> SceneDesc {
    let source = Source::new("s.toml".into(), format!("{SCENE}{random}\n"));
    parse(source.with(overrides.clone())).unwrap_or_else(|e| panic!("{e}"))
}

fn values(desc: &SceneDesc) -> Result<Values, String> {
    let random = desc.random.clone().expect("a table");
    Values::new(desc, &[ValueSource::Random(random.into())]).map_err(|e| e.to_string())
}

fn drawn(random: &str, frame: i64) -> Vec<(String, String)> {
    let values = values(&scene(random, &Overrides::default())).unwrap_or_else(|e| panic!("{e}"));
    let drawn = values.drawn_at(frame);
    drawn.map(|(name, text)| (name.to_owned(), text)).collect()
}

#[test]
fn a_draw_does_not_depend_on_other_values_and_depends_on_the_seed_the_scene_and_the_frame() {
    let alone = drawn("light.key.point.intensity = [1, 10]", 5);
    let among = drawn(
        "light.key.point.intensity = [1, 10]\nobject.ball.shape.sphere.radius = [1, 2]",
        5,
    );
    assert!(among.contains(&alone[0]) && among.len() == 2);
    let others = [
        drawn("light.key.point.intensity = [1, 10]", 6),
        drawn("seed = 1\nlight.key.point.intensity = [1, 10]", 5),
        drawn("scene = 'other'\nlight.key.point.intensity = [1, 10]", 5),
    ];
    let all: std::collections::HashSet<_> = others.iter().chain([&alone]).map(|drawn| &drawn[0].1).collect();
    assert_eq!(all.len(), 4);
    assert_eq!(drawn("scene = 's'\nlight.key.point.intensity = [1, 10]", 5), alone);
}

#[test]
fn values_that_are_wrong_somewhere_in_a_distribution_are_refused_with_its_line() {
    let line = 1 + SCENE.matches('\n').count();
    for (random, message) in [
        ("light.key.point.intensty = [1, 10]", "unknown key `intensty`"),
        ("light.fill.point.intensity = [1, 10]", "unknown light `fill`"),
        ("light.key.point.intensity = [-1, 10]", "expected"),
        ("light.key.point.position = [0, 1]", "expected"),
        ("light.key.point.intensity = ['a', 'b']", "expected"),
        ("object.ball.visible = [0, 1]", "expected"),
        ("object.ball.shape.sphere.radius = { choice = [1, 0] }", "expected"),
        ("render.samples = { integer = [1, 4] }", "holds for the whole job"),
        ("object.ball.name = ['a', 'b']", "holds for the whole job"),
        ("camera.shutter = [[0, 0], [0, 1]]", "holds for the whole job"),
        (
            "'material.m.matte.albedo' = [0, 1]\n'material.m.matte.albedo.r' = [0, 1]",
            "the draw `material.m.matte.albedo` sets the same value",
        ),
    ] {
        let found = values(&scene(random, &Overrides::default()))
            .map(drop)
            .expect_err(random);
        let place = format!("s.toml:{line}: ");
        let later = format!("s.toml:{}: ", line + 1);
        assert!(
            found.contains(message) && (found.contains(&place) || found.contains(&later)),
            "{random}: {found}"
        );
    }
}

#[test]
fn a_value_that_is_set_for_the_job_is_not_drawn() {
    let flags = Overrides::default().with("light.key.point.intensity", 7.0);
    let desc = scene(
        "light.key.point.intensity = [1, 10]\nobject.ball.shape.sphere.radius = [1, 2]",
        &flags,
    );
    let values = values(&desc).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(
        values.drawn_at(1).map(|(name, _)| name).collect::<Vec<_>>(),
        ["object.ball.shape.sphere.radius"]
    );
}

#[test]
fn a_normal_distribution_without_ends_is_refused_by_what_it_can_draw_whichever_frames_there_are() {
    let radius = |law: &str| {
        let random = format!("object.ball.shape.sphere.radius = {law}");
        values(&scene(&random, &Overrides::default())).map(drop)
    };
    let found = radius("{ normal = [1, 0.2] }").expect_err("a radius below 0");
    assert!(
        found.contains("found -0.7") && found.contains("`min` and `max` keep draws in a range"),
        "{found}"
    );
    for law in [
        "{ normal = [1, 0.2], min = 0.1 }",
        "{ normal = [1, 0.2], min = 0.1, max = 2 }",
        "{ normal = [1, 0.1] }",
    ] {
        radius(law).unwrap_or_else(|e| panic!("{law}: {e}"));
    }
}

#[test]
fn a_quaternion_of_normal_numbers_is_a_uniform_rotation() {
    let name = |component: &str| format!("object.ball.transform.rotate.{component} = {{ normal = [0, 1] }}\n");
    let desc = scene(&["qx", "qy", "qz", "qw"].map(name).concat(), &Overrides::default());
    let values = values(&desc).unwrap_or_else(|e| panic!("{e}"));
    let moving = crate::describe::MovingDesc::new(&desc, &values);
    let count = 2_000;
    let mut up = [0.0; 3];
    for frame in 1..=count {
        let object = moving.object(0, f64::from(frame)).expect("an object");
        let transform = object.transform.expect("a transform");
        let map = transform.get_ref().compile(0..0).expect("a rotation");
        assert!((map.matrix3.determinant() - 1.0).abs() < 1e-9);
        let axis = map.matrix3.y_axis.to_array();
        up.iter_mut().zip(axis).for_each(|(sum, v)| *sum += v * v);
    }
    // The square of each component of a uniform direction has the mean 1/3 and the variance 4/45.
    for sum in up {
        assert!((sum / f64::from(count) - 1.0 / 3.0).abs() < 0.035, "{up:?}");
    }
}

#[test]
fn a_value_with_a_part_that_is_set_for_the_whole_job_is_refused() {
    let red = Overrides::default().with("material.m.matte.albedo.r", 0.5);
    let whole = Overrides::default().with("material.m.matte.albedo", 0.5);
    let random = "'material.m.matte.albedo' = { choice = [0.1, 0.9] }";
    let refused = values(&scene(random, &red)).map(drop).expect_err("a part is set");
    assert!(
        refused.contains("`material.m.matte.albedo.r`, a part of this value"),
        "{refused}"
    );
    let set = values(&scene(random, &whole)).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(set.drawn_at(1).count(), 0, "what is set is not drawn");
}

#[test]
fn a_wildcard_draws_each_thing_that_has_the_value_by_itself_unless_it_has_a_source_of_its_own() {
    let more = |random: &str| {
        let text = SCENE.replace("[random]\n", "");
        let others = "[[object]]\nmaterial = 'm'\nshape.sphere = { radius = 2 }\n\
                      [[object]]\nname = 'floor'\nmaterial = 'm'\nshape.plane = { point = [0, 0, 0], normal = [0, 1, 0] }\n\
                      [[light]]\nsun = { direction = [0, -1, 0], irradiance = 1 }\n";
        let source = Source::new("s.toml".into(), format!("{text}{others}[random]\n{random}\n"));
        values(&parse(source).unwrap_or_else(|e| panic!("{e}")))
    };
    let drawn = |random: &str| -> Vec<(String, String)> {
        let values = more(random).unwrap_or_else(|e| panic!("{random}: {e}"));
        values.drawn_at(3).map(|(name, text)| (name.to_owned(), text)).collect()
    };
    let radii = drawn("'object.*.shape.sphere.radius' = [1, 2]");
    let names: Vec<&str> = radii.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        ["object.ball.shape.sphere.radius", "object.object 2.shape.sphere.radius"]
    );
    assert_ne!(radii[0].1, radii[1].1);
    // By its own name the value is the same.
    assert_eq!(drawn("object.ball.shape.sphere.radius = [1, 2]"), radii[..1]);
    let names = |random: &str| -> Vec<String> { drawn(random).into_iter().map(|(name, _)| name).collect() };
    assert_eq!(names("'object.*.material' = ['m']").len(), 3);
    assert_eq!(
        names("'object.*.material' = ['m']\n'object.floor.material' = 'none'\nobject.0.material = ['m']"),
        ["object.0.material", "object.object 2.material"]
    );
    assert_eq!(
        names("'light.*.point.intensity' = [1, 2]"),
        ["light.key.point.intensity"]
    );
    for (random, message) in [
        (
            "'light.*.spot.intensity' = [1, 2]",
            "s.toml:23: light.*.spot.intensity: no light of the scene has this value",
        ),
        ("'object.*.shape.sphere.radios' = [1, 2]", "unknown key `radios`"),
        ("'camera.*.fov' = [1, 2]", "camera.*.fov"),
    ] {
        let found = more(random).map(drop).expect_err(random);
        assert!(found.contains(message), "{random}: {found}");
    }
}

#[test]
fn a_value_that_is_drawn_can_be_taken_out_by_a_flag_in_whichever_form_it_is_written() {
    for random in [
        "light.key.point.intensity = [1, 10]",
        "'light.key.point.intensity' = { log = [1, 10] }",
    ] {
        let none = Overrides::default().with("random.light.key.point.intensity", "none");
        let desc = scene(&format!("object.ball.shape.sphere.radius = [1, 2]\n{random}"), &none);
        let values = values(&desc).unwrap_or_else(|e| panic!("{e}"));
        let names: Vec<&str> = values.drawn_at(1).map(|(name, _)| name).collect();
        assert_eq!(names, ["object.ball.shape.sphere.radius"]);
    }
    let read = read("'light.key.point.intensity' = 'none'\n").expect("a table");
    let left_out: Vec<&str> = read.left_out.iter().map(|left_out| left_out.name.as_str()).collect();
    assert_eq!(
        (names(&read).len(), &left_out[..]),
        (0, &["light.key.point.intensity"][..])
    );
    for (name, message) in [
        ("light.kez.point.intensity", "unknown"),
        ("nix", "unknown"),
        ("object.*.material", "no draw has this name"),
    ] {
        let none = Overrides::default().with(&format!("random.{name}"), "none");
        let found = values(&scene("object.ball.shape.sphere.radius = [1, 2]", &none)).map(drop);
        let found = found.expect_err(name);
        assert!(found.contains(message) && found.contains(name), "{name}: {found}");
    }
}
