// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/program/built_ins.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "lucarium/compute/device/device.h"
#include "lucarium/compute/program/identifiers.h"

namespace lucarium {
namespace {

/// Functions of the same overloads. In `overload`, T is the type, S its element, I and U the signed and the unsigned
/// integers of the same size, B what a comparison gives, W the width in letters, and A an address space; "result
/// parameters". In `names`, W is the width too.
struct Family {
  const char* names;
  const char* overload;
  const char* elements;  ///< f: floating point, i: integer, s: signed, w: int and uint, a: all; -: there is no T
  int first_width, last_width;
  const char* attribute;
};

constexpr const char* plain = "LUCARIUM_PLAIN";
constexpr const char* constant = "LUCARIUM_CONST";
constexpr const char* pure = "LUCARIUM_PURE";
constexpr const char* convergent = "LUCARIUM_CONVERGENT";
constexpr std::string_view attributes =
    "#define LUCARIUM_PLAIN __attribute__((overloadable))\n"
    "#define LUCARIUM_CONST __attribute__((overloadable, const))\n"
    "#define LUCARIUM_PURE __attribute__((overloadable, pure))\n"
    "#define LUCARIUM_CONVERGENT __attribute__((overloadable, convergent))\n";
constexpr std::string_view no_attributes =
    "#undef LUCARIUM_PLAIN\n#undef LUCARIUM_CONST\n#undef LUCARIUM_PURE\n#undef LUCARIUM_CONVERGENT\n";

constexpr Family families[] = {
    {"acos acosh acospi asin asinh asinpi atan atanh atanpi cbrt ceil cos cosh cospi degrees erf erfc exp exp10 exp2 "
     "expm1 fabs floor lgamma log log10 log1p log2 logb radians rint round rsqrt sign sin sinh sinpi sqrt tan tanh "
     "tanpi tgamma trunc",
     "T T", "f", 1, 16, constant},
    {"atan2 atan2pi copysign fdim fmax fmin fmod hypot max maxmag min minmag nextafter pow powr remainder step",
     "T T, T", "f", 1, 16, constant},
    {"fmax fmin max min", "T T, S", "f", 2, 16, constant},
    {"step", "T S, T", "f", 2, 16, constant},
    {"bitselect clamp fma mad mix smoothstep", "T T, T, T", "f", 1, 16, constant},
    {"mix", "T T, T, S", "f", 2, 16, constant},
    {"clamp", "T T, S, S", "f", 2, 16, constant},
    {"smoothstep", "T S, S, T", "f", 2, 16, constant},
    {"isfinite isinf isnan isnormal signbit", "B T", "f", 1, 16, constant},
    {"isequal isgreater isgreaterequal isless islessequal islessgreater isnotequal isordered isunordered", "B T, T",
     "f", 1, 16, constant},
    {"distance dot", "S T, T", "f", 1, 4, constant},
    {"length", "S T", "f", 1, 4, constant},
    {"normalize", "T T", "f", 1, 4, constant},
    {"cross", "T T, T", "f", 3, 4, constant},
    {"abs", "U T", "i", 1, 16, constant},
    {"abs_diff", "U T, T", "i", 1, 16, constant},
    {"clz popcount", "T T", "i", 1, 16, constant},
    {"add_sat hadd max min mul_hi rhadd rotate sub_sat", "T T, T", "i", 1, 16, constant},
    {"max min", "T T, S", "i", 2, 16, constant},
    {"bitselect clamp mad_hi mad_sat", "T T, T, T", "i", 1, 16, constant},
    {"clamp", "T T, S, S", "i", 2, 16, constant},
    {"mul24", "T T, T", "w", 1, 16, constant},
    {"mad24", "T T, T, T", "w", 1, 16, constant},
    {"all any", "int T", "s", 1, 16, constant},
    {"select", "T T, T, I", "a", 1, 16, constant},
    {"select", "T T, T, U", "a", 1, 16, constant},
    {"vloadW", "T size_t, const __constant S*", "a", 2, 16, pure},
    {"vloadW", "T size_t, const A S*", "a", 2, 16, pure},
    {"vstoreW", "void T, size_t, A S*", "a", 2, 16, plain},
    {"vload_half", "float size_t, const __constant half*", "-", 1, 1, pure},
    {"vload_half", "float size_t, const A half*", "-", 1, 1, pure},
    {"vload_halfW vloada_halfW", "floatW size_t, const __constant half*", "-", 2, 16, pure},
    {"vload_halfW vloada_halfW", "floatW size_t, const A half*", "-", 2, 16, pure},
    {"vstore_half vstore_half_rte vstore_half_rtn vstore_half_rtp vstore_half_rtz", "void T, size_t, A half*", "f", 1,
     1, plain},
    {"vstore_halfW vstore_halfW_rte vstore_halfW_rtn vstore_halfW_rtp vstore_halfW_rtz vstorea_halfW "
     "vstorea_halfW_rte vstorea_halfW_rtn vstorea_halfW_rtp vstorea_halfW_rtz",
     "void T, size_t, A half*", "f", 2, 16, plain},
    {"prefetch", "void const __global T*, size_t", "a", 1, 16, plain},
    {"atomic_add atomic_and atomic_max atomic_min atomic_or atomic_sub atomic_xchg atomic_xor",
     "T volatile __global T*, T", "w", 1, 1, plain},
    {"atomic_add atomic_and atomic_max atomic_min atomic_or atomic_sub atomic_xchg atomic_xor",
     "T volatile __local T*, T", "w", 1, 1, plain},
    {"atomic_xchg", "float volatile __global float*, float", "-", 1, 1, plain},
    {"atomic_xchg", "float volatile __local float*, float", "-", 1, 1, plain},
    {"atomic_dec atomic_inc", "T volatile __global T*", "w", 1, 1, plain},
    {"atomic_dec atomic_inc", "T volatile __local T*", "w", 1, 1, plain},
    {"atomic_cmpxchg", "T volatile __global T*, T, T", "w", 1, 1, plain},
    {"atomic_cmpxchg", "T volatile __local T*, T, T", "w", 1, 1, plain},
    {"get_global_id get_global_offset get_global_size get_group_id get_local_id get_local_size get_num_groups",
     "size_t uint", "-", 1, 1, constant},
    {"get_work_dim", "uint void", "-", 1, 1, constant},
    {"barrier", "void cl_mem_fence_flags", "-", 1, 1, convergent},
    {"mem_fence read_mem_fence write_mem_fence", "void cl_mem_fence_flags", "-", 1, 1, plain},
};

/// What else the driver declares, by name or, ending in *, by its beginning.
constexpr const char* unknown_names =
    "amd_* arm_dot* async_work_group_* atom_* atomic_* bit_reverse bitfield_* capture_event_profiling_info "
    "create_user_event ctz dot_* enqueue_marker fast_distance fast_length fast_normalize fract frexp "
    "get_default_queue get_enqueued_* get_fence get_global_linear_id get_image_* get_local_linear_id "
    "get_max_sub_group_size get_num_sub_groups get_sub_group* half_cos half_divide half_exp half_exp10 half_exp2 "
    "half_log half_log10 half_log2 half_powr half_recip half_rsqrt half_sin half_sqrt half_tan ilogb intel_* "
    "is_valid_reserve_id ldexp lgamma_r modf nan native_* ndrange_* pown printf read_image* release_event remquo "
    "retain_event rootn set_user_event_status shuffle shuffle2 sincos sub_group_* upsample vec_step "
    "wait_group_events work_group_* write_image*";

struct Element {
  const char *name, *signed_name, *unsigned_name, *kinds;
};
constexpr Element elements[] = {{"char", "char", "uchar", "isa"},    {"uchar", "char", "uchar", "ia"},
                                {"short", "short", "ushort", "isa"}, {"ushort", "short", "ushort", "ia"},
                                {"int", "int", "uint", "iswa"},      {"uint", "int", "uint", "iwa"},
                                {"long", "long", "ulong", "isa"},    {"ulong", "long", "ulong", "ia"},
                                {"float", "int", "uint", "fa"},      {"double", "long", "ulong", "fa"}};
constexpr int widths[] = {1, 2, 3, 4, 8, 16};

std::string width_text(int width) { return width == 1 ? "" : std::to_string(width); }

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  while (!text.empty()) {
    const size_t end = std::min(text.find(' '), text.size());
    words.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return words;
}

std::string replaced(std::string_view pattern, const Element& element, int width) {
  const std::string w = width_text(width);
  std::string text;
  for (const char c : pattern) {
    switch (c) {
      case 'T': text += element.name + w; break;
      case 'S': text += element.name; break;
      case 'I': text += element.signed_name + w; break;
      case 'U': text += element.unsigned_name + w; break;
      case 'B': text += width == 1 ? "int" : element.signed_name + w; break;
      case 'W': text += w; break;
      default: text += c;
    }
  }
  return text;
}

/// Of one name. Attributes are written as macros (declare_built_ins()).
struct Overloads {
  std::string lines, lines_with_double;
};
using Declarations = std::map<std::string, Overloads, std::less<>>;

/// `signature`: the result, then the parameters behind a space.
void declare(Declarations& all, const std::string& name, const std::string& signature, const char* attribute) {
  const size_t space = signature.find(' ');
  const std::string line =
      fmt::format("{} {} {}({});\n", signature.substr(0, space), attribute, name, signature.substr(space + 1));
  const bool is_double = signature.find("double") != std::string::npos;
  (is_double ? all[name].lines_with_double : all[name].lines) += line;
}

void declare_family(Declarations& all, const Family& family) {
  for (const int width : widths) {
    if (width < family.first_width || width > family.last_width) continue;
    for (const Element& element : elements) {
      const bool no_type = family.elements[0] == '-';
      if (no_type ? &element != elements
                  : std::string_view(element.kinds).find(family.elements[0]) == std::string::npos)
        continue;
      const std::string signature = replaced(family.overload, element, width);
      for (const std::string_view word : words_of(family.names)) {
        const std::string name = replaced(word, element, width);
        const size_t space = signature.find(" A ");
        if (space == std::string::npos) {
          declare(all, name, signature, family.attribute);
          continue;
        }
        for (const char* address_space : {" __global ", " __local ", " __private "}) {
          std::string placed = signature;
          declare(all, name, placed.replace(space, 3, address_space), family.attribute);
        }
      }
    }
  }
}

void declare_conversions(Declarations& all) {
  for (const int width : widths) {
    for (const Element& to : elements) {
      for (const Element& from : elements) {
        const std::string signature = to.name + width_text(width) + " " + from.name + width_text(width);
        const bool is_integer = std::string_view(to.kinds).find('i') != std::string::npos;
        for (const char* rounding : {"", "_rte", "_rtn", "_rtp", "_rtz"}) {
          const std::string name = fmt::format("convert_{}{}", to.name, width_text(width));
          declare(all, name + rounding, signature, constant);
          if (is_integer) declare(all, name + "_sat" + rounding, signature, constant);
        }
      }
    }
  }
}

Declarations declare_all() {
  Declarations all;
  for (const Family& family : families) declare_family(all, family);
  declare_conversions(all);
  return all;
}

bool is_unknown(std::string_view name) {
  static const std::vector<std::string_view> unknown = words_of(unknown_names);
  return std::any_of(unknown.begin(), unknown.end(), [&](std::string_view each) {
    return each.ends_with('*') ? name.starts_with(each.substr(0, each.size() - 1)) : name == each;
  });
}

}  // namespace

bool can_declare_built_ins(const DeviceInfo& device) {
  return device.is_pocl && device.type == DeviceType::cpu && device.driver_version.starts_with("3.1");
}

std::optional<std::string> declare_built_ins(std::string_view source) {
  static const Declarations all = declare_all();
  const bool pastes = source.find("##") != std::string_view::npos;  // such as name##4
  std::set<std::string> needed;
  for (const std::string_view name : identifiers_of(source)) {
    if (all.contains(name))
      needed.emplace(name);
    else if (is_unknown(name))
      return std::nullopt;
    if (!pastes) continue;
    for (const int width : widths)
      if (const std::string wide = std::string(name) + width_text(width); all.contains(wide)) needed.insert(wide);
  }
  std::string text = "#ifdef cl_khr_fp16\n#error overloads for half are not declared\n#endif\n", with_double;
  text += attributes;
  for (const std::string& name : needed) {
    const Overloads& overloads = all.find(name)->second;
    text += overloads.lines;
    with_double += overloads.lines_with_double;
  }
  return text + "#ifdef cl_khr_fp64\n#pragma OPENCL EXTENSION cl_khr_fp64 : enable\n" + with_double + "#endif\n" +
         std::string(no_attributes);
}

}  // namespace lucarium
