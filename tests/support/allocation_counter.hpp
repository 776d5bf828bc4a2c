#pragma once

namespace holdfast::test {

/// Calls of operator new, of any form, in this process so far, whichever thread or library makes them.
long operator_new_count();

}  // namespace holdfast::test
