#pragma once

namespace holdfast::python {

/// To be called before anything that OpenCL or OpenGL has a part in. Throws Error(device) in a process that was forked
/// after its parent came by here: the drivers' threads are not in the child, which would wait for them for ever.
void require_one_process();

}  // namespace holdfast::python
