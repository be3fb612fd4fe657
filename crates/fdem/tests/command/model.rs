//! Tests of `fdem new` and `fdem check`: output, exit codes, and files beside the model.

use std::path::Path;

use crate::Bench;

#[test]
fn a_new_model_is_one_that_checks() {
    let bench = Bench::new();
    let run = bench.run(&["new"]).succeeds();
    assert!(run.stderr.contains("wrote model.toml; next: fdem check model.toml"), "{}", run.stderr);
    let run = bench.run(&["check", "model.toml"]).succeeds();
    for part in ["bodies           3: disc, upper platen, lower platen", "critical step", "steps", "run time"]
    {
        assert!(run.stdout.contains(part), "{}", run.stdout);
    }
    assert!(!run.stdout.contains("warning"), "{}", run.stdout);
    assert!(run.stderr.contains("box              disc: "), "{}", run.stderr);
    assert_eq!(bench.files(), ["model.toml"]);
}

/// The steps of a fine mesh take minutes, those of a coarse one about a second.
#[test]
fn a_long_run_is_rehearsed_with_a_coarse_mesh() {
    let bench = Bench::new();
    bench.run(&["new"]).succeeds();
    let text = std::fs::read_to_string(bench.path("model.toml")).unwrap();
    let sizes: Vec<&str> = text.lines().filter(|line| line.starts_with("mesh_size")).collect();
    let fine = sizes.iter().fold(text.clone(), |text, line| text.replace(line, "mesh_size = 0.0004"));
    bench.write("model.toml", fine);
    let run = bench.run(&["check", "model.toml"]).succeeds();
    assert!(run.stdout.contains(" on one core, by a rehearsal with "), "{}", run.stdout);
    let run = bench.run(&["check", "model.toml", "--json"]).succeeds();
    let found: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(found["rehearsal"]["done"]["elements"].as_u64().is_some_and(|count| count < 2000), "{found}");
    assert!(found["seconds"].as_f64() > found["seconds_whole"].as_f64(), "{found}");
}

#[test]
fn joints_in_space_are_told_with_their_number_faces_and_area() {
    let bench = Bench::new();
    let model = "[model]\nend_time = 1e-3\n[[body]]\nname = \"block\"\nmaterial = \"rock\"\nbox = { min = [0, 0, 0], max = [1, 1, 1] }\nmesh_size = 0.25\n\
                 [[material]]\nname = \"rock\"\ndensity = 2700\nyoungs_modulus = 30e9\npoissons_ratio = 0.25\n\
                 [[joint_set]]\nname = \"bedding\"\nfriction_angle = 30\ndip = 0\ndip_direction = 0\nspacing = 0.4\norigin = [0, 0, 0.3]\n";
    bench.write("model.toml", model);
    let run = bench.run(&["check", "model.toml"]).succeeds();
    assert!(run.stdout.contains("joints           bedding: 2, 2 m² together, on "), "{}", run.stdout);
    bench.write("model.toml", model.replacen("dip_direction = 0\n", "", 1));
    bench.run(&["check", "model.toml"]).refused_with(&["model.toml:16", "needs a dip_direction"]);
}

/// A block with a fault, a boundary, histories and stages, which `check` draws.
const DRAWN: &str = r#"[model]
end_time = 1e-3
[[body]]
name = "block"
material = "rock"
rectangle = { min = [0, 0], max = [1, 0.5] }
mesh_size = 0.1
[[body]]
name = "lid"
material = "rock"
rectangle = { min = [0, 0.5], max = [1, 0.6] }
mesh_size = 0.1
[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.25
[[joint_set]]
name = "fault"
lines = [[0.2, 0.1, 0.8, 0.4]]
friction_angle = 30
[[boundary]]
name = "floor"
body = "block"
side = "bottom"
velocity = [0, 0]
[[history]]
name = "middle"
stress = [0.5, 0.25]
[[history]]
name = "long gauge"
gauge = [[0.1, 0.25], [0.9, 0.25]]
[[stage]]
name = "rest"
duration = 5e-4
[[stage]]
name = "open"
excavate = ["lid"]
"#;

#[test]
fn a_model_is_drawn_before_its_run() {
    let bench = Bench::new();
    bench.write("model.toml", DRAWN);
    let run = bench.run(&["check", "model.toml", "--picture", "model.svg"]).succeeds();
    assert!(run.stdout.contains("bodies           2: block, lid"), "{}", run.stdout);
    let svg = bench.read("model.svg");
    for part in ["block", "lid", "fault", "floor", "middle", "long gauge", "rest", "open: removes lid"] {
        assert!(svg.contains(&format!(">{part}</text>")), "{part} is not in\n{svg}");
    }
    let path = |class: &str| {
        let rest = svg.split(&format!("class=\"{class}\" d=\"")).nth(1).unwrap();
        rest.split('"').next().unwrap().to_owned()
    };
    // Ten edges along the floor, at one height.
    let floor = path("boundary");
    assert_eq!(floor.matches('M').count(), 10, "{floor}");
    let heights: std::collections::BTreeSet<&str> =
        floor.split(['M', 'L']).filter_map(|point| point.split(' ').nth(1)).collect();
    assert_eq!(heights.len(), 1, "{floor}");
    assert!(path("joints").matches('M').count() >= 6, "{}", path("joints"));
    // The marker of a point on the picture and in the legend: one and two points, and two rows.
    assert_eq!(svg.matches("<circle").count(), 5);
    bench.run(&["check", "model.toml", "--picture", "model.png", "--picture-width", "600"]).succeeds();
    let png = std::fs::read(bench.path("model.png")).unwrap();
    assert_eq!(&png[16..20], 600_u32.to_be_bytes());
    bench.run(&["check", "model.toml", "--picture", "model.jpg"]).refused_with(&[".svg or .png"]);
    bench.run(&["check", "model.toml", "--picture", "no/folder.svg"]).refused_with(&["there is no folder"]);
    bench.write("model.svg", DRAWN);
    bench.run(&["check", "model.svg", "--picture", "model.svg"]).refused_with(&["is the same file"]);
    assert_eq!(bench.read("model.svg"), DRAWN);
}

/// In three dimensions the surface is an image, with the outlines of joints above it.
#[test]
fn a_model_in_space_is_drawn_before_its_run() {
    let bench = Bench::new();
    let model = "[model]\nend_time = 1e-3\n[[body]]\nname = \"block\"\nmaterial = \"rock\"\nbox = { min = [0, 0, 0], max = [1, 1, 1] }\nmesh_size = 0.25\n\
                 [[material]]\nname = \"rock\"\ndensity = 2700\nyoungs_modulus = 30e9\npoissons_ratio = 0.25\n\
                 [[joint_set]]\nname = \"bedding\"\nfriction_angle = 30\ndip = 0\ndip_direction = 0\nspacing = 0.4\norigin = [0, 0, 0.3]\n\
                 [[boundary]]\nname = \"roof\"\nbody = \"block\"\nside = \"top\"\npressure = 1e5\n";
    bench.write("model.toml", model);
    bench.run(&["check", "model.toml", "--picture", "model.svg"]).succeeds();
    let svg = bench.read("model.svg");
    for part in ["block", "bedding", "roof"] {
        assert!(svg.contains(&format!(">{part}</text>")), "{part} is not in the legend");
    }
    assert!(svg.contains("data:image/png;base64,") && svg.contains("class=\"joints\" d=\"M"));
    bench.run(&["check", "model.toml", "--picture", "model.png"]).succeeds();
    assert!(std::fs::read(bench.path("model.png")).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn a_model_that_is_there_is_replaced_only_if_that_is_asked_for() {
    let bench = Bench::new();
    bench.write("mine.toml", "precious");
    bench.run(&["new", "mine.toml"]).refused_with(&["mine.toml", "--force"]);
    assert_eq!(bench.read("mine.toml"), "precious");
    bench.run(&["new", "mine.toml", "--force"]).succeeds();
    assert!(bench.read("mine.toml").starts_with("# A model"));
    bench.run(&["new", "no/such/folder.toml"]).refused_with(&["folder.toml"]);
}

#[test]
fn mistakes_are_drawn_with_file_line_and_pointer() {
    let bench = Bench::new();
    bench.run(&["new"]).succeeds();
    let text = bench
        .read("model.toml")
        .replacen("density", "densty", 1)
        .replace("plane = \"stress\"", "plane = \"strss\"");
    bench.write("model.toml", text);
    bench.run(&["check", "model.toml"]).refused_with(&[
        "model.toml has 2 errors",
        "--> model.toml:11:",
        "did you mean \"stress\"?",
        "did you mean \"density\"?",
        "^^^",
    ]);
}

#[test]
fn files_are_looked_for_beside_the_model() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("folder")).unwrap();
    bench.write("folder/mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let model = "[model]\nend_time = 1\n[[body]]\nname = \"a\"\nmaterial = \"m\"\nmesh = \"mesh.obj\"\n\
        [[material]]\nname = \"m\"\ndensity = 1\nyoungs_modulus = 1\npoissons_ratio = 0\n";
    bench.write("folder/model.toml", model);
    let run = bench.run(&["check", "folder/model.toml", "--json"]).succeeds();
    let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(json["quality"]["elements"], 1);
    bench.write("folder/model.toml", model.replace("mesh.obj", "gone.obj"));
    bench.run(&["check", "folder/model.toml"]).refused_with(&["cannot read gone.obj", "model.toml:6:"]);
}

/// A program "gmsh" that writes the mesh beside it and its arguments, or fails.
#[cfg(unix)]
#[test]
fn a_geometry_is_meshed_by_gmsh() {
    use std::os::unix::fs::PermissionsExt;

    let bench = Bench::new();
    bench.write(
        "model.toml",
        "[model]\nend_time = 1\n[[body]]\nname = \"a\"\nmaterial = \"m\"\nmesh = \"part.step\"\nmesh_size = 0.25\n\
         [[material]]\nname = \"m\"\ndensity = 1\nyoungs_modulus = 1\npoissons_ratio = 0\n",
    );
    bench.write("part.step", "the geometry");
    std::fs::create_dir(bench.path("bin")).unwrap();
    let bin = bench.path("bin").display().to_string();
    let gmsh = |script: &str| {
        bench.write("bin/gmsh", format!("#!/bin/sh\n{script}\n"));
        std::fs::set_permissions(bench.path("bin/gmsh"), std::fs::Permissions::from_mode(0o755)).unwrap();
    };
    let check = |path: &str, folder: Option<&str>| {
        let mut command = bench.command(&["check", "model.toml", "--json"]);
        command.env("PATH", path);
        if let Some(folder) = folder {
            command.env("TMPDIR", folder);
        }
        let output = command.output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap())
    };
    let (code, said) = check("", None);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("there is no program") && said.contains("install Gmsh"), "{said}");
    assert!(said.contains("\"line\": 6"), "{said}");

    let mesh = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n$Elements\n1\n1 4 2 1 1 1 2 3 4\n$EndElements\n";
    bench.write("bin/made.msh", mesh);
    let real = format!("{bin}:/usr/bin:/bin");
    gmsh(&format!(
        "echo \"$@\" > {bin}/arguments; while [ \"$1\" != -o ]; do shift; done; cat \"$3\" > {bin}/geometry; cp {bin}/made.msh \"$2\""
    ));
    let (code, said) = check(&real, None);
    assert_eq!(code, Some(0), "{said}");
    let json: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!(json["quality"]["elements"], 1);
    let arguments = bench.read("bin/arguments");
    assert!(arguments.starts_with("-3 ") && arguments.contains("-clmax 0.25 "), "{arguments}");
    assert!(arguments.contains("-setstring Geometry.OCCTargetUnit M "), "{arguments}");
    assert_eq!(bench.read("bin/geometry"), "the geometry");

    gmsh("echo Info : reading; echo 'Error : no such shape' >&2; exit 3");
    let (code, said) = check(&real, None);
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("Gmsh made no mesh of part.step") && said.contains("Error : no such shape"),
        "{said}"
    );
    assert!(!said.contains("reading"), "{said}");

    // Gmsh names the copy that it was given, as its last argument.
    gmsh("for file; do :; done; echo \"Error : '$file', line 3: syntax error\"; exit 1");
    let (_, said) = check(&real, None);
    assert!(said.contains("Error : 'part.step', line 3: syntax error"), "{said}");

    gmsh("exit 0");
    assert!(check(&real, None).1.contains("Gmsh made no mesh of part.step"));

    let (code, said) = check(&real, Some("/no/such/folder"));
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("cannot make a temporary folder for Gmsh"), "{said}");

    let text = bench.read("model.toml");
    bench.write("model.toml", text.replace("mesh_size = 0.25\n", ""));
    assert!(check(&real, None).1.contains("lacks the key \\\"mesh_size\\\""));
}

/// Gmsh ends and its folder is removed when the command that waits for them is interrupted.
#[cfg(unix)]
#[test]
fn gmsh_ends_with_the_command_that_runs_it() {
    use std::os::unix::fs::PermissionsExt;
    use std::os::unix::process::ExitStatusExt;
    use std::process::{Command, Stdio};
    use std::thread::sleep;
    use std::time::Duration;

    let bench = Bench::new();
    bench.write(
        "model.toml",
        "[model]\nend_time = 1\n[[body]]\nname = \"a\"\nmaterial = \"m\"\nmesh = \"part.step\"\nmesh_size = 0.25\n\
         [[material]]\nname = \"m\"\ndensity = 1\nyoungs_modulus = 1\npoissons_ratio = 0\n",
    );
    bench.write("part.step", "the geometry");
    for folder in ["bin", "tmp"] {
        std::fs::create_dir(bench.path(folder)).unwrap();
    }
    let bin = bench.path("bin").display().to_string();
    bench.write(
        "bin/gmsh",
        format!("#!/bin/sh\necho $$ > {bin}/new\nmv {bin}/new {bin}/pid\nexec sleep 100\n"),
    );
    std::fs::set_permissions(bench.path("bin/gmsh"), std::fs::Permissions::from_mode(0o755)).unwrap();
    let kill = |signal: &str, pid: &str| {
        Command::new("kill").args([signal, pid]).stderr(Stdio::null()).status().unwrap().success()
    };
    for (task, signal, code) in
        [("check", "-TERM", 143), ("check", "-INT", 130), ("run", "-TERM", 143), ("run", "-INT", 130)]
    {
        let mut command = bench.command(&[task, "model.toml"]);
        command.env("PATH", format!("{bin}:/usr/bin:/bin")).env("TMPDIR", bench.path("tmp"));
        let mut fdem = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        while !bench.path("bin/pid").exists() {
            assert_eq!(fdem.try_wait().unwrap(), None, "it ended before Gmsh began");
            sleep(Duration::from_millis(10));
        }
        let gmsh = bench.read("bin/pid");
        assert_eq!(std::fs::read_dir(bench.path("tmp")).unwrap().count(), 1);
        assert!(kill(signal, &fdem.id().to_string()));
        let status = fdem.wait().unwrap();
        assert_eq!((status.code(), status.signal()), (Some(code), None), "{task} {signal}");
        assert!(!kill("-0", gmsh.trim()), "Gmsh still runs after {task} {signal}");
        assert_eq!(std::fs::read_dir(bench.path("tmp")).unwrap().count(), 0, "its folder is left");
        std::fs::remove_file(bench.path("bin/pid")).unwrap();
    }
}

#[test]
fn what_is_no_model_is_refused() {
    let bench = Bench::new();
    bench.run(&["check"]).refused_with(&["MODEL"]);
    for threads in ["-1", "1025", "two"] {
        let run = bench.run(&["run", "gone.toml", &format!("--threads={threads}")]);
        run.refused_with(&[threads, "a whole number from 0 to "]);
    }
    if std::thread::available_parallelism().map_or(1, std::num::NonZero::get) < 50 {
        let run = bench.run(&["run", "gone.toml", "--threads", "1000"]);
        run.refused_with(&["1000", "is needed: more only wait for the processors"]);
    }
    bench.run(&["run", "gone.toml", "--threads", "64"]).refused_with(&["cannot read gone.toml"]);
    bench.run(&["check", "gone.toml"]).refused_with(&["cannot read gone.toml"]);
    #[cfg(unix)]
    {
        bench.run(&["check", "/dev/zero"]).refused_with(&["/dev/zero", "64 MiB"]);
        let model = "[model]\nend_time = 1\n[[body]]\nname = \"a\"\nmaterial = \"m\"\nmesh = \"/dev/zero\"\n\
            [[material]]\nname = \"m\"\ndensity = 1\nyoungs_modulus = 1\npoissons_ratio = 0\n";
        bench.write("endless.toml", model);
        bench.run(&["check", "endless.toml"]).refused_with(&["/dev/zero", "device"]);
    }
    bench.write("bytes.toml", b"[model]\n\xff\xfe");
    bench.run(&["check", "bytes.toml"]).refused_with(&["bytes.toml:2: this is not UTF-8 text"]);
}

#[test]
fn the_schema_is_json() {
    let bench = Bench::new();
    let run = bench.run(&["check", "--schema"]).succeeds();
    let schema: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(schema["properties"]["body"]["type"], "array");
}

#[test]
fn errors_are_json_where_that_is_asked_for() {
    let bench = Bench::new();
    bench.run(&["new"]).succeeds();
    bench.write("model.toml", bench.read("model.toml").replacen("density", "densty", 1));
    let errors = |name: &str| {
        let run = bench.run(&["check", name, "--json"]);
        assert_eq!(run.code, Some(2), "{}", run.stderr);
        let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
        json["errors"].clone()
    };
    let wrong = errors("model.toml");
    assert!(wrong[0]["message"].as_str().unwrap().contains("no key \"densty\""), "{wrong}");
    assert_eq!(wrong[0]["help"], "did you mean \"density\"?");
    let line = 1 + bench.read("model.toml").lines().position(|line| line.starts_with("densty")).unwrap();
    assert_eq!(wrong[0]["line"], line);
    assert!(errors("gone.toml")[0]["message"].as_str().unwrap().contains("cannot read gone.toml"));
}

#[test]
fn a_run_on_many_ranks_is_foretold() {
    let bench = Bench::new();
    bench.run(&["new"]).succeeds();
    let run = bench.run(&["check", "model.toml", "--ranks", "16"]).succeeds();
    for part in
        ["ranks            16,", "own elements", "halo elements", "neighbours", "messages", "assumed: 2 µs"]
    {
        assert!(run.stdout.contains(part), "{part:?} is not in\n{}", run.stdout);
    }
    let one = bench.run(&["check", "model.toml", "--json"]).succeeds();
    let one: serde_json::Value = serde_json::from_str(&one.stdout).unwrap();
    assert!(one.get("on_ranks").is_none());
    let run = bench.run(&["check", "model.toml", "--json", "--ranks", "16"]).succeeds();
    let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let ranks = json["on_ranks"]["forecast"]["of_ranks"].as_array().unwrap();
    assert_eq!(ranks.len(), 16);
    let own: u64 = ranks.iter().map(|rank| rank["own"].as_u64().unwrap()).sum();
    assert_eq!(json["quality"]["elements"], own);
    assert!(ranks.iter().all(|rank| rank["neighbours"].as_u64().unwrap() > 0));
    assert!(json["on_ranks"]["halo_share"].as_f64().unwrap() > 0.0);
}

#[test]
fn ranks_without_elements_are_refused() {
    let bench = Bench::new();
    bench.run(&["new"]).succeeds();
    let run = bench.run(&["check", "model.toml", "--json"]).succeeds();
    let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let elements = json["quality"]["elements"].as_u64().unwrap();
    let [most, more] = [elements, elements + 1].map(|ranks| ranks.to_string());
    bench.run(&["check", "model.toml", "--ranks", &most]).succeeds();
    bench
        .run(&["check", "model.toml", "--ranks", &more])
        .refused_with(&[&format!("{more} ranks are more than the {most} elements of the model")]);
    bench.run(&["check", "model.toml", "--ranks", "0"]).refused_with(&["a run on 0 ranks computes nothing"]);
    for ranks in ["-1", "many", "1.5"] {
        let run = bench.run(&["check", "model.toml", &format!("--ranks={ranks}")]);
        run.refused_with(&[ranks, "a whole number above 0 is needed"]);
    }
    bench.run(&["check", "--schema", "--ranks", "4"]).refused_with(&["--ranks"]);
}

#[test]
fn a_template_in_space_is_named_with_or_without_its_end() {
    let bench = Bench::new();
    for (name, more) in [("pillar", &["--3d"][..]), ("pillar_3d", &["--3d"]), ("pillar_3d", &[])] {
        let file = format!("{name}{}.toml", more.len());
        bench.run(&[&["new", "--template", name, file.as_str()], more].concat()).succeeds();
    }
    let texts = bench.files().into_iter().map(|file| std::fs::read_to_string(bench.path(&file)).unwrap());
    let texts: Vec<String> = texts.collect();
    assert!(texts.len() == 3 && texts.iter().all(|text| *text == texts[0]));
    let run = bench.run(&["new", "--3d", "--template", "tunnel", "t.toml"]);
    run.refused_with(&["\"tunnel\" is in the plane", "pillar", "stairs"]);
    assert!(!bench.path("t.toml").exists());
}

#[test]
fn the_cases_of_the_ladder_are_listed() {
    let bench = Bench::new();
    let run = bench.run(&["validate", "--list"]).succeeds();
    assert!(run.stdout.starts_with(" 1 waves in bars\n"), "{}", run.stdout);
    bench.run(&["validate", "nonsense"]).refused_with(&["no case 'nonsense'", "\n 1 waves in bars\n"]);
}

#[test]
fn every_template_checks() {
    let bench = Bench::new();
    let run = bench.run(&["new", "--list"]).succeeds();
    assert!(bench.files().is_empty());
    let names: Vec<&str> = run.stdout.lines().filter_map(|line| line.split(' ').next()).collect();
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let models = [examples.clone(), examples.join("space")].map(|folder| {
        let files = std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
        files.filter(|file| file.extension().is_some_and(|end| end == "toml")).count()
    });
    assert_eq!(
        names.len(),
        3 + models.iter().sum::<usize>(),
        "two starters, the direct shear test and all examples:\n{}",
        run.stdout
    );
    for line in run.stdout.lines() {
        assert!(line.len() > 30, "a template says what it is: {line}");
    }
    // The library checks all examples (`every_example_is_right`), and each is its template: some do here.
    let some = |name: &&str| {
        crate::thorough()
            || name.contains("starter")
            || ["direct_shear", "tunnel", "pillar_3d"].contains(name)
    };
    for name in names.into_iter().filter(some) {
        bench.run(&["new", "m.toml", "--force", "--template", name]).succeeds();
        let run = bench.run(&["check", "m.toml"]).succeeds();
        // Two are loaded faster than a test should be, so that they take seconds.
        let fast = ["crushed_ball_3d", "pillar_3d"].contains(&name);
        assert_eq!(run.stdout.contains("warning"), fast, "{name}: {}", run.stdout);
        assert_eq!(run.stdout.contains("by inertia"), fast, "{name}: {}", run.stdout);
    }
    bench.run(&["new", "n.toml", "--template", "brasilian_disc"]).refused_with(&["brazilian_disc"]);
}

/// A run keeps the files that its model includes, and continues without those beside the model.
#[test]
fn a_run_with_included_files_is_resumed_from_its_folder_alone() {
    let bench = Bench::new();
    let text = "include = \"../lib/rock.toml\"\n[model]\nthickness = \"10 cm\"\n[[body]]\nname = \"a\"\nmaterial = \"rock\"\n\
        rectangle = { min = [0, 0], max = [\"edge\", \"edge\"] }\nmesh_size = \"edge/4\"\nrepeat = [2, 1]\nvelocity = [1, 0]\n";
    let rock = "include = \"time.toml\"\n[parameters]\nedge = \"1 m\"\n[[material]]\nname = \"rock\"\ndensity = 2500\nyoungs_modulus = \"1 GPa\"\npoissons_ratio = 0.2\n";
    let time = "[model]\nend_time = \"1 ms\"\n";
    let write = || {
        for folder in ["lib", "case"] {
            std::fs::create_dir(bench.path(folder)).unwrap();
        }
        bench.write("case/model.toml", text);
        bench.write("lib/rock.toml", rock);
        bench.write("lib/time.toml", time);
    };
    write();
    bench.run(&["run", "-q", "case/model.toml", "--output", "short"]).succeeds();
    bench.write("lib/time.toml", time.replace('1', "2"));
    bench.run(&["run", "-q", "case/model.toml", "--output", "long"]).succeeds();
    for folder in ["lib", "case"] {
        std::fs::remove_dir_all(bench.path(folder)).unwrap();
    }
    bench.run(&["check", "short/model.toml"]).succeeds();
    bench.run(&["resume", "-q", "short", "--end-time", "2e-3"]).succeeds();
    let json = |folder: &str| {
        serde_json::from_str::<serde_json::Value>(&bench.read(&format!("{folder}/run.json"))).unwrap()
    };
    let (short, long) = (json("short"), json("long"));
    assert_eq!(short["status"], "finished");
    assert!(short["state_hash"].is_string(), "{short}");
    assert_eq!(short["state_hash"], long["state_hash"]);
    // A mistake in an included file has its name in JSON.
    write();
    bench.write("lib/rock.toml", rock.replace("density", "densty"));
    let run = bench.run(&["check", "case/model.toml", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!((run.code, json["errors"][0]["line"].as_u64()), (Some(2), Some(6)), "{json}");
    assert_eq!(json["errors"][0]["file"], "case/../lib/rock.toml");
}

/// The library is listed with its sources, a material of it is a table of a model file, and `check` reports
/// the keys from it.
#[test]
fn the_library_of_materials_is_listed() {
    let bench = Bench::new();
    let list = bench.run(&["materials"]).succeeds().stdout;
    for material in fdem::model::library() {
        assert!(list.contains(&format!("\n{}: {}. ", material.name, material.about)), "{list}");
    }
    let granite = list.lines().find(|line| line.starts_with("granite ")).unwrap();
    let cells: Vec<&str> = granite.split_whitespace().collect();
    assert_eq!(cells, ["granite", "2650", "60", "0.25", "0.6", "10", "35", "50", "45", "225"]);
    let table = bench.run(&["materials", "granite"]).succeeds().stdout;
    let body = "[model]\nend_time = 1e-6\n[[body]]\nname = \"block\"\nmaterial = \"granite\"\nmesh_size = 0.01\n\
        rectangle = { min = [0, 0], max = [0.04, 0.02] }\n";
    bench.write("whole.toml", format!("{body}{table}"));
    bench.write("short.toml", format!("{body}[[material]]\nname = \"granite\"\nlibrary = \"granite\"\n"));
    let hash = |name: &str| {
        let text = bench.run(&["check", name, "--json"]).succeeds().stdout;
        let json: serde_json::Value = serde_json::from_str(&text).unwrap();
        (json["hash"].clone(), json["from_library"].clone())
    };
    let (whole, short) = (hash("whole.toml"), hash("short.toml"));
    assert_eq!(whole.0, short.0);
    assert_eq!(whole.1, serde_json::json!([]));
    assert_eq!(
        (&short.1[0]["library"], short.1[0]["keys"].as_array().unwrap().len()),
        (&"granite".into(), 9)
    );
    bench.run(&["materials", "granit"]).refused_with(&["granit", "granite"]);
}
