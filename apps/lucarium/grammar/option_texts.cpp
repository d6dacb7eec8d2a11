// SPDX-License-Identifier: Apache-2.0
#include "grammar/option_texts.h"

#include "lucarium/base/error.h"
#include "lucarium/base/text/text_values.h"

namespace lucarium::app {
namespace {

const OptionText entries[] = {
    // Words by their place.
    {"scene", "", "SCENE", "a .gltf or .glb file, or builtin:NAME[:key=value,...]"},
    {"technique", "", "NAME", "a technique (see lucarium techniques)"},
    {"name", "", "NAME", "name of the new technique: letters a-z, digits, _"},
    {"experiment", "", "PAPER[/EXPERIMENT]", "one experiment, or all of a paper"},
    {"folder", "", "FOLDER", "results of a comparison"},
    {"test", "", "TEST", "image under test"},
    {"reference", "", "REFERENCE", "reference image"},
    {"file", "", "FILE", "job as JSON (schema lucarium-job-1)"},
    {"batch", "", "FOLDER", "folder of an array"},
    {"index", "", "N", "task of the array"},
    {"state", "", "FILE", "a state that --save-state wrote"},
    {"command", "", "COMMAND", "a command of the program"},
    {"shell", "", "SHELL", "bash, zsh or fish", "bash|zsh|fish"},
    {"kind", "", "KIND", "what is completed", "scene|technique|parameter|experiment"},
    {"words", "", "WORDS", "the words of the line, up to the cursor"},

    {"-o,--output", "Output", "FILE", "where to write the result"},
    {"--overwrite", "Output", "", "replace what is there"},
    {"--half", "Output", "", "16-bit floats in .exr files"},
    {"--profile", "Output", "[=FILE]", "time per pass: a table, or FILE.json, FILE.trace.json (Perfetto)"},
    {"--watch", "Output", "", "render again when the scene, the plug-in or a kernel in use changes"},
    {"--save-state", "Output", "FILE", "save light that does not depend on the camera"},
    {"--compress-state", "Output", "", "compress the state with zlib"},
    {"--export", "Output", "FILE.glb", "write the scene as it is understood"},
    {"--link-images", "Output", "", "report with images beside it, in full precision"},
    {"--resume", "Output", "", "continue what was interrupted in the same folder"},
    {"--extend", "Output", "", "add samples to the file if it is there"},
    {"--gate", "Output", "[LABEL:]METRIC<VALUE", "exit code 1 when missed; also METRIC>VALUE"},
    {"--baseline", "Output", "FOLDER", "earlier results: print what changed"},
    {"--map-of", "Output", "ERROR", "what the map shows: signed (relative luminance error), ldr_flip or hdr_flip",
     "signed|ldr_flip|hdr_flip"},
    {"--max-relmse", "Checks", "E", "exit code 1 when relMSE is above this"},
    {"--statistical", "Checks", "", "test whether two renderings differ by noise alone; exit code 1 when not"},
    {"--formulas", "Output", "", "print what every metric means"},
    {"--markdown", "Output", "", "print the page of the documentation"},
    {"--list", "Output", "", "print papers and their experiments"},
    {"--dry-run", "Output", "", "print the plan; render nothing but first iterations"},

    {"--spp", "Budget", "N", "stop at this many samples per pixel"},
    {"--iterations", "Budget", "N", "stop after this many iterations of the technique"},
    {"--time", "Budget", "SECONDS", "stop after this time of preparing and iterating"},
    {"--wall-time", "Budget", "SECONDS", "stop after this time since the start, loading included"},
    {"--relmse", "Budget", "E", "stop when relMSE is at most this"},
    {"--limit", "Budget", "SECONDS", "time after which --relmse gives up"},
    {"--reference", "Budget", "FILE", "image to measure the error against"},
    {"--curve", "Budget", "", "record the error over time, at t·2^(i/2)"},
    {"--reference-spp", "Budget", "N", "maximum samples per pixel of a rendered reference"},
    {"--reference-relmse", "Budget", "E", "stop a rendered reference at this relMSE of its own"},
    {"--comparison", "Budget", "FILE.json", "file that states scenes, techniques and budgets"},
    {"--seeds", "Budget", "N", "independent runs of each technique"},
    {"--full", "Budget", "", "full settings instead of quick ones; may take hours"},
    {"--only", "Budget", "PART", "run only checks whose names begin with this"},

    {"--size", "Image", "WxH", "image size [pixels]"},
    {"--max-bounces", "Image", "N", "indirect bounces; 0: direct light only, -1: unlimited"},
    {"--pixel-sampling", "Image", "MODE", "positions in a pixel: jitter, center, or N for a grid of N×N",
     "jitter|center"},
    {"--seed", "Image", "N", "seed of random numbers; same seed, same image"},
    {"--exposure", "Image", "STOPS", "exposure of pictures and of metrics on them; not of .exr files"},

    {"--camera", "Scene", "CAMERA", "name, index, or EYE:TARGET[:VFOV] as x,y,z:x,y,z:degrees"},
    {"--camera-path", "Scene", "PATH", "name, FILE.json, linear:… or spline:… (docs/scenes.md)"},
    {"--environment", "Scene", "SKY", "sky: image, R,G,B or none; *FACTOR, @DEGREES"},
    {"--light", "Scene", "LIGHT", "point:X,Y,Z:R,G,B, spot:…, directional:…, none"},
    {"--material", "Scene", "NAME:KEY=VALUE,…", "change materials; NAME may hold *"},
    {"--no-sidecar", "Scene", "", "ignore FILE.lucarium.json beside the scene"},
    {"--texture-size", "Scene", "N", "maximum texture size [pixels]; larger textures are downscaled"},
    {"--at", "Scene", "SECONDS", "time of the animation"},
    {"--animation", "Scene", "NAME", "animation by name or index"},
    {"--fallback-environment", "Scene", "R,G,B", "sky of scenes without any light"},

    {"--atlas", "Atlas", "FILE", "write the charts of the surface atlas (.exr or .png)"},
    {"--atlas-view", "Atlas", "FILE", "write what the camera sees, every texel in its color (.exr or .png)"},
    {"--atlas-texels", "Atlas", "N", "wanted texel sides of the atlas"},
    {"--atlas-edge", "Atlas", "METRES", "wanted texel edge, instead of --atlas-texels"},
    {"--atlas-texcoord1", "Atlas", "", "lay the atlas out by TEXCOORD_1 where there is one"},

    {"-t,--technique", "Technique", "NAME[:KEY=VALUE,…]", "technique with parameters; see lucarium techniques"},
    {"-p,--parameter", "Technique", "KEY=VALUE,…", "parameters of the technique named before"},
    {"--technique-path", "Technique", "FOLDER", "folder of plug-ins, searched first"},
    {"--load-state", "Technique", "FILE", "begin with light that --save-state wrote"},
    {"--path-set", "Technique", "KEY=VALUE,…", "light paths, instead of a technique's"},

    {"--port", "Page", "N", "port of the page; 0: a free one"},
    {"--listen", "Page", "ADDRESS", "where to listen; other machines reach what is not 127.0.0.1"},
    {"--open", "Page", "", "open the page in this system's browser"},

    {"--frames", "Animation", "FIRST:LAST", "render frames; out.exr becomes out.0000.exr and so on"},
    {"--fps", "Animation", "N", "frames per second of --frames"},

    {"--devices,--device", "Device", "DEVICE", "index, name, cpu, gpu or accelerator; or several",
     "all|cpu|gpu|accelerator"},
    {"--executor", "Device", "NAME", "what runs the work: local, or slurm (docs/slurm.md)", "local|slurm"},
    {"--slurm", "Device", "OPTION", "option for sbatch, as partition=long or exclusive"},
    {"--threads", "Device", "N", "worker threads of a CPU device; 0: all"},
    {"--cache-dir", "Device", "FOLDER", "folder of compiled kernels and references"},
    {"--no-cache", "Device", "", "compile every kernel again"},
    {"--memory-limit", "Device", "SIZE", "maximum device memory, as 500M or 2G"},
    {"--allocation-limit", "Device", "SIZE", "maximum size of one device buffer, as 500M"},

    {"--json", "Messages", "", "print the result as JSON on standard output"},
    {"-q,--quiet", "Messages", "", "print results and errors only: no progress, no warnings"},
    {"-v,--verbose", "Messages", "", "details of errors, and what is being done"},
    {"-h,--help", "Messages", "", "print this help"},
    {"-V,--version", "Messages", "", "print the version"},
};

}  // namespace

const OptionText& option_text(std::string_view name) {
  for (const OptionText& entry : entries) {
    for (const std::string& own : split(entry.names, ',')) {
      if (own == name) return entry;
    }
  }
  throw_error(ErrorClass::internal, "the option {} has no text", name);
}

std::vector<std::string> option_words(std::string_view name) { return split(option_text(name).words, '|'); }

const std::vector<const char*>& option_groups() {
  static const std::vector<const char*> groups = {"Output",    "Checks", "Budget",    "Image",  "Scene",   "Atlas",
                                                  "Technique", "Page",   "Animation", "Device", "Messages"};
  return groups;
}

}  // namespace lucarium::app
