//! Files to the library's types.
