//! Examples of every command: the last section of its `--help`. A line that begins with two blanks and `octray` is a command,
//! which a test gives to the parser; what it does stands below it.

/// Where to begin: of `octray` alone, and of its `--help`.
pub const FIRST: &str = "\
Examples:
  octray render builtin:lamp_hall -o hall.png --time 10s
      an image in ten seconds
  octray converge scenes/cornell.toml --out report
      error against run time of every strategy, as a report
  octray info scenes/cornell.toml
      what a scene holds, and what a render of it does and leaves out";

/// Of `octray render`.
pub const RENDER: &str = "\
Examples:
  octray render scenes/cornell.toml -o cornell.exr -o cornell.png
      with the scene's own settings: radiance and noise as EXR, PNG to look at
  octray render scenes/cornell.toml -o out/cornell.exr --time 1m30s
      as many samples as a minute and a half allows
  octray render scenes/cornell.toml -o cornell.exr --target-error 5%
      as many as bring the noise down to 5 % of the mean radiance
  octray render scenes/sky.toml -o sky.png --width 320 --height 240 --exposure 1
      a small one, a stop brighter
  octray render builtin:lamp_hall -o hall.exr --strategy nee --lights power
      another way to estimate direct light and to choose its lights
  octray render builtin:rooms --frames 0..47 -o walk/####.png --spp 32
      two seconds of a camera that moves, a file a frame
  octray render part.obj -o part.png --look-from 3,2,4 --look-at 0,0,0 --studio
      a bare mesh: a camera, a ground and a soft light from outside
  octray render scenes/glass.toml -o glass.exr --spp 65536 --every 1m
      a long one: after whatever ends it, the same command goes on
  octray render scenes/glass.toml -o glass.exr --layers all --half --zip
      with albedo, normals and depth, as denoisers take them, in a small file
  octray render scenes/sky.toml -o temple.png --hide-environment
      with alpha, to be put before something else
  octray render scenes/glass.toml --shard 2/8 -o glass.2 --spp 65536
      the second of eight parts; octray merge makes the image of them";

/// Of `octray merge`.
pub const MERGE: &str = "\
Examples:
  octray merge glass.1 glass.2 glass.3 -o glass.exr -o glass.png
      the image that one machine would have made, bit for bit
  octray merge glass.1 glass.3 --list
      which parts there are, and which are missing";

/// Of `octray completions`.
pub const COMPLETIONS: &str = "\
Examples:
  octray completions bash
      what bash is to read: see its own completion folder
  octray completions fish
      the same for fish";

/// Of `octray man`.
pub const MAN: &str = "\
Examples:
  octray man --out man1
      the pages of all commands
  octray man --out share/man/man1
      where man looks for them";

/// Of `octray info`.
pub const INFO: &str = "\
Examples:
  octray info scenes/cornell.toml
      its tables, the stages of a render, and what those do without
  octray info scenes/cornell.toml --strategy bsdf --json=plan.json
      the same of another strategy, for programs";

/// Of `octray trace`.
pub const TRACE: &str = "\
Examples:
  octray trace scenes/cornell.toml --pixel 250,300 --sample 0
      the story of one sample of one pixel
  octray trace scenes/glass.toml --pixel 200,200 --sample 3 --both
      every value of every ray in both engines
  octray trace check:corridor:1000 --pixel 1,1 --sample 0 --json
      a path of a scene of octray check, for programs";

/// Of `octray check`.
pub const CHECK: &str = "\
Examples:
  octray check
      the built-in suite
  octray check --filter mis/ --thorough
      one group of it, with a hundred times the samples
  octray check scenes/cornell.toml --json=check.json
      what applies to a scene; the rows also as JSON";

/// Of `octray bench`.
pub const BENCH: &str = "\
Examples:
  octray bench
      of a scene with 1.2 million triangles
  octray bench scenes/cornell.toml --size 128 --runs 9
      of your own, smaller and with more rounds
  octray bench scenes/cornell.toml --strategy nee --json=bench.json
      of another strategy; the rows as JSON
  octray bench heavy.obj --rays heavy.primary.rays --rays heavy.shadow.rays
      of rays that another ray tracer is given, too
  octray bench --scaling --plot scaling.svg
      how the time of a path grows with the scene, the film and the threads";

/// Of `octray converge`.
pub const CONVERGE: &str = "\
Examples:
  octray converge scenes/cornell.toml --out report
      every strategy at 1 to 256 samples a pixel; then open report/report.html
  octray converge scenes/cornell.toml --out report --times 500ms,1s,2s
      at equal time
  octray converge builtin:lamp_hall --out hall --strategies nee --lights all
      one strategy with three ways to choose lights";

/// Of `octray diff`.
pub const DIFF: &str = "\
Examples:
  octray diff cornell.exr reference.exr
      the error of an image against a reference
  octray diff cornell.exr reference.exr --heatmap error.png
      and where it is
  octray diff cornell.exr reference.exr --json
      for programs";
