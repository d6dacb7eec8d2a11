// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include "lucarium/compute/schedule/bind_arguments.h"
#include "schedule_fixture.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// A pass over the signature (const float4* rays, uint* hits, uint count, Camera camera, local float* scratch).
struct Pass {
  KernelSignature signature;
  RecordedStep step;
  std::vector<RecordedResource> resources;

  Pass() {
    signature.name = "trace";
    signature.arguments = {{"rays", "float4*", ArgumentAccess::read},
                           {"hits", "uint*", ArgumentAccess::read_write},
                           {"count", "uint", ArgumentAccess::value},
                           {"camera", "Camera", ArgumentAccess::value},
                           {"scratch", "float*", ArgumentAccess::local}};
    step.signature = &signature;
    for (const char* name : {"ray buffer", "hit buffer"}) {
      resources.emplace_back();
      resources.back().name = name;
    }
  }
  void bind(RecordedArgument::Kind kind, const char* name, int index, std::string_view type = "") {
    RecordedArgument& argument = step.arguments.emplace_back();
    argument.name = name;
    argument.kind = kind;
    argument.index = index;
    argument.type = type;
  }
  void buffer(const char* name, int resource) { bind(RecordedArgument::Kind::buffer, name, resource); }
  void value(const char* name, std::string_view type) { bind(RecordedArgument::Kind::value, name, -1, type); }
  void local(const char* name) { bind(RecordedArgument::Kind::local, name, -1); }
  void bind_values() {
    value("count", "uint");
    bind(RecordedArgument::Kind::variable, "camera", 0, "Camera");
    local("scratch");
  }
  BoundArguments result() const { return bind_arguments("pass 'p'", step, resources); }
  std::string error() const {
    return error_message([&] { result(); });
  }
};

}  // namespace

TEST_CASE("arguments are bound by name, in any order, and give the accesses") {
  Pass pass;
  pass.bind_values();
  pass.buffer("hits", 1);
  pass.buffer("rays", 0);
  pass.step.discards = {"hits"};
  const BoundArguments bound = pass.result();
  REQUIRE(bound.by_position.size() == 5);
  CHECK(bound.by_position[0]->name == "rays");
  CHECK(bound.by_position[3]->name == "camera");
  REQUIRE(bound.accesses.size() == 2);
  CHECK((bound.accesses[0].resource == 1 && bound.accesses[0].writes && bound.accesses[0].discards));
  CHECK((bound.accesses[1].resource == 0 && !bound.accesses[1].writes && !bound.accesses[1].discards));
}

TEST_CASE("every wrong binding is named") {
  Pass pass;
  pass.buffer("rays", 0);
  SUBCASE("unknown") {
    pass.buffer("hitz", 1);
    CHECK(pass.error() == "pass 'p': the kernel has no argument 'hitz'; did you mean 'hits'?");
  }
  SUBCASE("named as a function of OpenCL") {
    pass.signature.arguments.push_back({"_cl_distance", "float", ArgumentAccess::value});
    pass.value("distance", "float");
    CHECK(pass.error() ==
          "pass 'p': the driver calls the argument 'distance' '_cl_distance', since an OpenCL function has that name; "
          "rename it");
  }
  SUBCASE("missing") {
    pass.bind_values();
    CHECK(pass.error() == "pass 'p': argument 'hits' is not bound; it is a buffer (uint*)");
  }
  SUBCASE("twice") {
    pass.buffer("rays", 1);
    CHECK(pass.error() == "pass 'p': argument 'rays' is bound twice");
  }
  SUBCASE("mistyped value") {
    pass.value("count", "int");
    CHECK(pass.error() ==
          "pass 'p': argument 'count' is a value of type uint, but a value of type int was bound to it");
  }
  SUBCASE("mistyped variable") {
    pass.bind(RecordedArgument::Kind::variable, "camera", 0, "float4");
    CHECK(pass.error() ==
          "pass 'p': argument 'camera' is a value of type Camera, but a value of type float4 was bound to it");
  }
  SUBCASE("buffer for a value") {
    pass.buffer("count", 1);
    CHECK(pass.error() == "pass 'p': argument 'count' is a value of type uint, but a buffer was bound to it");
  }
  SUBCASE("value for a buffer") {
    pass.value("hits", "uint");
    CHECK(pass.error() == "pass 'p': argument 'hits' is a buffer (uint*), but a value of type uint was bound to it");
  }
  SUBCASE("buffer for local memory") {
    pass.buffer("scratch", 1);
    CHECK(contains(pass.error(), "argument 'scratch' is local memory (local_memory()), but a buffer was bound"));
  }
  SUBCASE("discards of an unknown argument") {
    pass.step.discards = {"hit"};
    CHECK(contains(pass.error(), "discards(\"hit\") names no argument; did you mean 'hits'?"));
  }
  SUBCASE("discards of a const argument") {
    pass.step.discards = {"rays"};
    CHECK(contains(pass.error(), "discards(\"rays\"), but the kernel does not write 'rays'"));
  }
  SUBCASE("slices without a base") {
    pass.buffer("hits", 1);
    pass.bind_values();
    pass.step.slice_items = 64;
    CHECK(contains(pass.error(), "slice() needs a kernel argument 'uint slice_base'"));
  }
}

TEST_CASE("a buffer may be bound twice only where all of its arguments are const or none is") {
  Pass pass;
  pass.bind_values();
  pass.buffer("rays", 0);
  pass.buffer("hits", 0);
  CHECK(contains(pass.error(), "buffer 'ray buffer' is bound to 'hits' (written) and also to a const argument"));
  pass.signature.arguments[0].access = ArgumentAccess::read_write;
  pass.step.discards = {"hits"};
  const BoundArguments written = pass.result();
  REQUIRE(written.accesses.size() == 1);
  CHECK(written.accesses[0].writes);
  CHECK_FALSE(written.accesses[0].discards);  // the other argument may read
  pass.step.discards.clear();
  pass.signature.arguments[0].access = pass.signature.arguments[1].access = ArgumentAccess::read;
  CHECK(pass.result().accesses.size() == 1);
}

TEST_CASE("slice_base is bound by the schedule") {
  Pass pass;
  pass.bind_values();
  pass.buffer("rays", 0);
  pass.buffer("hits", 1);
  pass.signature.arguments.push_back({"slice_base", "uint", ArgumentAccess::value});
  CHECK(pass.result().slice_base == 5);
}

TEST_CASE("compile() names schedule, pass and kernel") {
  KernelScheduler scheduler(test_device());
  const auto buffer = make_buffer("numbers", Uints(64, 1));
  ScheduleRecorder recorder = scheduler.record("sums", "test");
  CHECK(contains(error_message([&] { recorder.pass("p", schedule_program(), "mix_im"); }), "mix_in"));
  recorder.pass("mix", schedule_program(), "write_pattern")
      .global(64)
      .arg("target", buffer)
      .arg("salt", 1)
      .arg("count", 64u);
  CHECK(error_message([&] { recorder.compile(); }) ==
        "schedule 'sums': pass 'mix' (kernel 'write_pattern'): argument 'salt' is a value of type uint, but a value of "
        "type int was bound to it");
}

TEST_CASE("compile() refuses sizes that cannot work") {
  KernelScheduler scheduler(test_device());
  const auto buffer = make_buffer("numbers", Uints(64, 1));
  ScheduleRecorder recorder = scheduler.record("sizes", "test");
  const auto compile_error = [&] { return error_message([&] { recorder.compile(); }); };
  recorder.pass("p", schedule_program(), "needs_32").arg("out", buffer);
  CHECK(contains(compile_error(), "no global size"));
  recorder.pass("p", schedule_program(), "needs_32").global(64).local(64).arg("out", buffer);
  CHECK(contains(compile_error(), "local size 64x1x1, but the kernel requires 32x1x1"));
  recorder.pass("p", schedule_program(), "needs_32").global(64).local(0).arg("out", buffer);
  CHECK(contains(compile_error(), "local size 0x1x1 is empty"));
  const size_t too_much = test_device()->info().local_memory_bytes + 4;
  recorder.pass("p", schedule_program(), "use_local").global(64).local_memory("scratch", too_much).arg("out", buffer);
  CHECK(contains(compile_error(), "bytes of local memory"));
  recorder.pass("p", schedule_program(), "needs_32").global(64).arg("out", buffer);
  recorder.pass("q", schedule_program(), "use_local")
      .global(64)
      .local(64)
      .local_memory("scratch", 256)
      .arg("out", buffer);
  Schedule schedule = recorder.compile();
  scheduler.run(schedule);
  const Uints values = buffer.download();
  for (uint32_t i = 0; i < 64; ++i) REQUIRE(values[i] == 63 - i);
}

TEST_CASE("transients and variables of another schedule are refused, and so is reading what nobody wrote") {
  KernelScheduler scheduler(test_device());
  const auto buffer = make_buffer("numbers", Uints(64, 1));
  ScheduleRecorder first = scheduler.record("first", "test"), second = scheduler.record("second", "test");
  const BufferRef foreign = first.transient<uint32_t>("foreign", 64);
  const Variable<uint32_t> foreign_value = first.variable<uint32_t>("salt", 1);
  PassBuilder pass = second.pass("p", schedule_program(), "overwrite");
  CHECK(contains(error_message([&] { pass.arg("source", foreign); }), "a transient of another schedule"));
  CHECK(contains(error_message([&] { pass.arg("salt", foreign_value); }), "a variable of another schedule"));
  CHECK(contains(error_message([&] { pass.arg("source", BufferRef()); }), "a buffer that was never created"));
  pass.global(64)
      .arg("target", buffer)
      .arg("source", second.transient<uint32_t>("empty", 64))
      .arg("salt", 1u)
      .arg("count", 64u);
  CHECK(error_message([&] { second.compile(); }) ==
        "schedule 'second': transient 'empty' is read by 'p' before any pass has written it");
  Schedule third = second.compile();
  CHECK(contains(error_message([&] { third.set(foreign_value, 2u); }), "a variable of another schedule"));
}

TEST_CASE("arg_if_present binds what the kernel has and leaves out the rest") {
  KernelScheduler scheduler(test_device());
  const TypedBuffer<uint32_t> target = make_buffer("target", Uints(4, 0)), other = make_buffer("other", Uints(4, 9));
  ScheduleRecorder recorder = scheduler.record("pattern", "test");
  PassBuilder pass = recorder.pass("pattern", schedule_program(), "write_pattern");
  CHECK(pass.has_argument("salt"));
  CHECK_FALSE(pass.has_argument("source"));
  pass.global(4)
      .arg_if_present("target", target)
      .arg_if_present("source", other)
      .arg_if_present("source", TypedBuffer<uint32_t>())  // never made
      .arg_if_present("salt", 5u)
      .arg_if_present("factor", 6u)
      .arg_if_present("count", 4u);
  Schedule schedule = recorder.compile();
  scheduler.run(schedule);
  scheduler.finish();
  CHECK(target.download() == Uints{5, 12, 19, 26});
}
