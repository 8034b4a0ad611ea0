// Containment at the boundary to Rust.
#pragma once

#include <cfenv>
#include <exception>
#include <stdexcept>

namespace feeler_oracle {

// The default floating-point environment for its lifetime.
class DefaultEnvironment {
 public:
    DefaultEnvironment() {
        std::fegetenv(&saved_);
        std::fesetenv(FE_DFL_ENV);
    }
    ~DefaultEnvironment() { std::fesetenv(&saved_); }
    DefaultEnvironment(const DefaultEnvironment&) = delete;

 private:
    std::fenv_t saved_;
};

void silence_cgal();

// Runs f; some exceptions of CGAL are no std::exception and would end the process.
template <class F>
auto guarded(F f) {
    const DefaultEnvironment environment;
    silence_cgal();
    try {
        return f();
    } catch (const std::exception&) {
        throw;
    } catch (...) {
        throw std::runtime_error("an exception of CGAL that is no std::exception");
    }
}

}  // namespace feeler_oracle
