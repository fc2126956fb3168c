//! Grounds from pictures in scenes: how high they are where, how they are given and written, what is wrong with them.

use std::fs::{self, File};
use std::path::Path;

use bevy::math::DVec3;
use plumb::physics::{Position, RigidBody, TriangleMesh, headless_app, step};
use plumb::scene::{SceneSpec, ShapeSpec, SurfaceForm, SurfaceSpec, builtin_height_pictures, load};
use png::{BitDepth, ColorType};

/// Writes a PNG of those bytes.
fn write_png(path: &Path, [width, height]: [u32; 2], color: ColorType, depth: BitDepth, bytes: &[u8]) {
    let mut encoder = png::Encoder::new(File::create(path).expect("a file"), width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if color == ColorType::Indexed {
        encoder.set_palette(vec![0, 0, 0, 51, 51, 51, 255, 255, 255]);
    }
    encoder.write_header().and_then(|mut writer| writer.write_image_data(bytes)).expect("a picture");
}

/// A scene file in a folder with a ground of that shape.
fn scene_in(folder: &Path, shape: &str) -> Result<SceneSpec, String> {
    let path = folder.join("scene.ron");
    fs::write(&path, format!(r#"(bodies: [(name: "ground", shape: {shape})])"#)).expect("a file");
    load(path.to_str().expect("UTF-8"), &[]).map_err(|error| {
        let message = error.to_string();
        assert!(!message.contains(['\n', '\r']), "one line: {message}");
        message.strip_prefix(&format!("{}: ", path.display())).expect("names the scene").to_owned()
    })
}

fn surface(scene: &SceneSpec) -> &SurfaceSpec {
    let Some(ShapeSpec::Surface(surface)) = &scene.bodies[0].shape else { panic!("a surface") };
    surface
}

/// Heights of a ground, sorted by z, then by x.
fn heights_of(surface: &SurfaceSpec) -> Vec<f64> {
    let mut vertices: Vec<DVec3> = surface.mesh().vertices().collect();
    vertices.sort_by(|a, b| (a.z, a.x).partial_cmp(&(b.z, b.x)).expect("finite"));
    vertices.iter().map(|vertex| vertex.y).collect()
}

/// Heights of a ground of a picture with those bytes and three columns, black at 0 and white at that height.
fn heights(color: ColorType, depth: BitDepth, bytes: &[u8], white: f64) -> Vec<f64> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bits = 3 * color.samples() * depth as usize;
    write_png(&folder.path().join("a.png"), [3, (bytes.len() / bits.div_ceil(8)) as u32], color, depth, bytes);
    let shape = format!(r#"Heights(size: (4, 6), file: "a.png", height: (0, {white:?}))"#);
    heights_of(surface(&scene_in(folder.path(), &shape).expect("a scene")))
}

#[test]
fn a_pixel_is_as_high_as_its_value() {
    let bytes: Vec<u8> = (0..=u8::MAX).chain([7, 0]).collect();
    let of_bytes: Vec<f64> = bytes.iter().copied().map(f64::from).collect();
    assert_eq!(heights(ColorType::Grayscale, BitDepth::Eight, &bytes, 255.0), of_bytes);
    let words: Vec<u16> = (0..=u16::MAX).chain([7, 0]).collect();
    let of_words: Vec<f64> = words.iter().copied().map(f64::from).collect();
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
    assert_eq!(heights(ColorType::Grayscale, BitDepth::Sixteen, &bytes, 65535.0), of_words);
}

#[test]
fn black_and_white_are_as_high_as_told_in_any_order_and_rows_of_pixels_go_along_x_from_minus_z() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let pixels = [0, 51, 255, 102, 204, 153];
    write_png(&folder.path().join("a.png"), [3, 2], ColorType::Grayscale, BitDepth::Eight, &pixels);
    let of = |height: &str| {
        let shape = format!(r#"Heights(size: (4, 6), file: "a.png", height: {height})"#);
        scene_in(folder.path(), &shape).expect("a scene")
    };
    let scene = of("(-1, 1.5)");
    assert_eq!(scene.bodies[0].kind, RigidBody::Static);
    let expected = [[-2.0, -1.0, -3.0], [0.0, -0.5, -3.0], [2.0, 1.5, -3.0]];
    let expected = expected.into_iter().chain([[-2.0, 0.0, 3.0], [0.0, 1.0, 3.0], [2.0, 0.5, 3.0]]);
    let mut found: Vec<DVec3> = surface(&scene).mesh().vertices().collect();
    for at in expected.map(DVec3::from) {
        let place = found.iter().position(|vertex| vertex.distance(at) < 1e-15);
        found.swap_remove(place.unwrap_or_else(|| panic!("no vertex at {at}: {found:?}")));
    }
    assert!(found.is_empty(), "{found:?}");
    let mirrored = heights_of(surface(&of("(1.5, -1)")));
    let sums = heights_of(surface(&scene)).into_iter().zip(mirrored).map(|(one, other)| one + other);
    assert!(sums.clone().all(|sum| (sum - 0.5).abs() < 1e-15), "{:?}", sums.collect::<Vec<_>>());
    assert_eq!(heights_of(surface(&of("(0.1, 0.1)"))), [0.1; 6], "flat");
}

#[test]
fn colors_count_by_their_luma_and_opacity_does_not() {
    let grey_with_opacity = [10, 0, 20, 255, 30, 7, 40, 0, 50, 0, 60, 0];
    let expected = [10.0, 20.0, 30.0, 40.0, 50.0, 60.0];
    assert_eq!(heights(ColorType::GrayscaleAlpha, BitDepth::Eight, &grey_with_opacity, 255.0), expected);
    let greys: Vec<u8> = [10, 20, 30, 40, 50, 60].into_iter().flat_map(|grey| [grey; 3]).collect();
    assert_eq!(heights(ColorType::Rgb, BitDepth::Eight, &greys, 255.0), expected, "grey, stored as color");
    let colors: Vec<u8> = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].into_iter().cycle().take(6).flatten().collect();
    let rgba: Vec<u8> = colors.chunks(3).flat_map(|rgb| [255 * rgb[0], 255 * rgb[1], 255 * rgb[2], 9]).collect();
    let luma = [0.2126, 0.7152, 0.0722, 0.2126, 0.7152, 0.0722];
    for (found, expected) in heights(ColorType::Rgba, BitDepth::Eight, &rgba, 1.0).into_iter().zip(luma) {
        assert!((found - expected).abs() < 1e-15, "{found} {expected}");
    }
    // Indices of the palette, two bits each: black, a fifth, white.
    assert_eq!(
        heights(ColorType::Indexed, BitDepth::Two, &[0b0001_1000, 0b1001_0000], 255.0),
        [0.0, 51.0, 255.0, 255.0, 51.0, 0.0]
    );
    assert_eq!(
        heights(ColorType::Grayscale, BitDepth::One, &[0b0110_0000, 0b1000_0000], 1.0),
        [0.0, 1.0, 1.0, 1.0, 0.0, 0.0]
    );
}

#[test]
fn it_is_written_as_the_file_that_it_is_from_and_comes_back_from_a_world() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::create_dir(folder.path().join("pictures")).expect("a folder");
    let file = folder.path().join("pictures/a.png");
    write_png(&file, [2, 2], ColorType::Grayscale, BitDepth::Eight, &[0, 60, 120, 255]);
    let shape = r#"Heights(size: (4.0, 6.0), file: "pictures/a.png", height: (-0.5, 0.1))"#;
    let scene = scene_in(folder.path(), shape).expect("a scene");
    assert_eq!(scene.bodies[0].shape.as_ref().and_then(ShapeSpec::path), Some(&*file), "what is watched for changes");
    let text = scene.to_ron(Some(folder.path())).expect("a text");
    assert!(text.contains(&format!("shape: {shape}")), "{text}");
    let source = folder.path().join("scene.ron");
    assert_eq!(SceneSpec::from_ron(&text, source.to_str().expect("UTF-8")).expect("a scene"), scene);
    let anywhere = scene.to_ron(None).expect("a text");
    assert!(anywhere.contains(file.to_str().expect("UTF-8")), "{anywhere}");
    assert!(SceneSpec::from_ron(&anywhere, "/somewhere/else.ron").is_ok());

    let mut app = headless_app();
    scene.spawn(app.world_mut());
    let captured = SceneSpec::of_world(app.world_mut(), "scene");
    assert_eq!(captured.bodies[0].shape, scene.bodies[0].shape);
    assert_eq!(captured.to_ron(Some(folder.path())).expect("a text"), text);
    let SurfaceForm::Picture { size, height, .. } = surface(&captured).form() else { panic!("a picture") };
    assert_eq!((*size, *height), ([4.0, 6.0], [-0.5, 0.1]));
}

#[test]
fn the_picture_that_comes_with_plumb_bears_a_ball() {
    assert_eq!(builtin_height_pictures().collect::<Vec<_>>(), ["plumb:hills.png"]);
    let text = r#"(bodies: [
        (name: "hills", shape: Heights(size: (24, 24), file: "plumb:hills.png", height: (0, 3))),
        (name: "ball", shape: Sphere(radius: 0.3), position: (0, 4, 0)),
    ])"#;
    let scene = SceneSpec::from_ron(text, "anywhere/scene.ron").expect("a scene");
    let own = heights_of(surface(&scene));
    assert_eq!(
        (own.iter().copied().fold(f64::INFINITY, f64::min), own.iter().copied().fold(0.0, f64::max)),
        (0.0, 3.0)
    );
    assert_eq!(scene.bodies[0].shape.as_ref().and_then(ShapeSpec::path), None);
    assert!(scene.to_ron(None).expect("a text").contains(r#"file: "plumb:hills.png""#));
    let mut app = headless_app();
    let spawned = scene.spawn(app.world_mut());
    for _ in 0..300 {
        step(app.world_mut());
        let at = app.world().get::<Position>(spawned.bodies[1]).expect("there").0;
        assert!(at.y > 0.25, "it fell through: {at}");
    }
    let at = app.world().get::<Position>(spawned.bodies[1]).expect("there").0;
    assert!(at.y < 3.2, "it fell: {at}");
}

#[test]
fn what_is_wrong_with_one_is_told_in_a_line_that_names_the_place() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let grey = |name: &str, size: [u32; 2]| {
        let bytes = vec![0; size[0] as usize * size[1] as usize];
        write_png(&folder.path().join(name), size, ColorType::Grayscale, BitDepth::Eight, &bytes);
    };
    let refused = |fields: &str| {
        let error = scene_in(folder.path(), &format!("Heights(size: (1, 1), {fields})")).expect_err("it is bad");
        error.strip_prefix("bodies[0].shape.").expect("names the place").to_owned()
    };
    let of_file = |name: &str| {
        let error = refused(&format!(r#"file: "{name}", height: (0, 1)"#));
        error.strip_prefix("file: ").expect("names the place").to_owned()
    };
    for (fields, expected) in [
        (r#"file: "a.png", height: (0, 1), rows: [[0, 0], [0, 0]]"#, "file: give either 'file' or 'rows', not both"),
        (r#"file: "a.png""#, "height: a picture has no unit; give the heights of black and of white in m"),
        (
            "rows: [[0, 0], [0, 0]], height: (0, 1)",
            "height: a height is for a 'file'; give rows of heights as high as they are",
        ),
    ] {
        assert_eq!(refused(fields), expected, "{fields}");
    }
    assert_eq!(
        of_file("missing.png"),
        format!(
            "{} cannot be read: No such file or directory (os error 2); a picture's path is relative to its scene's file",
            at("missing.png")
        )
    );
    assert!(of_file(".").contains("cannot be read: "), "{}", of_file("."));
    assert_eq!(of_file("plumb:alps.png"), "no picture 'plumb:alps.png' comes with Plumb; there is plumb:hills.png");
    fs::write(folder.path().join("text.png"), "v 0 0 0\n").expect("a file");
    assert_eq!(
        of_file("text.png"),
        format!("{} is not a whole PNG picture (Invalid PNG signature); export it as PNG", at("text.png"))
    );
    grey("cut.png", [20, 20]);
    let whole = fs::read(folder.path().join("cut.png")).expect("a file");
    for length in [0, 4, 20, whole.len() - 20] {
        fs::write(folder.path().join("cut.png"), &whole[..length]).expect("a file");
        assert!(of_file("cut.png").starts_with(&format!("{} is not a whole PNG picture (", at("cut.png"))), "{length}");
    }
    for size in [[1, 1], [1, 9], [9, 1]] {
        grey("thin.png", size);
        let [width, height] = size;
        assert_eq!(
            of_file("thin.png"),
            format!("{} has {width} x {height} pixels; give at least 2 x 2", at("thin.png"))
        );
    }
    grey("fine.png", [726, 726]);
    assert_eq!(
        of_file("fine.png"),
        format!(
            "{} has 726 x 726 pixels, which are 1051250 triangles of at most 1048576; scale it down, a square to 725 x 725",
            at("fine.png")
        )
    );
    const { assert!(2 * 724 * 724 <= TriangleMesh::MOST_TRIANGLES && 2 * 725 * 725 > TriangleMesh::MOST_TRIANGLES) };
    grey("flat.png", [2, 2]);
    assert_eq!(
        refused(r#"file: "flat.png", height: (1e70, 0)"#),
        format!("file: {}: vertex 0 (counted from 0) is not finite; give finite coordinates", at("flat.png"))
    );
    let text = |height: &str| {
        format!(r#"(bodies: [(name: "a", shape: Heights(size: (1, 1), file: "flat.png", height: {height}))])"#)
    };
    let error = SceneSpec::from_ron(&text("(0, inf)"), "scene.ron").expect_err("it is bad").to_string();
    assert_eq!(error, "scene.ron:1:82: must be finite, is inf");
}
