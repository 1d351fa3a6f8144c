use octray::internal::simd::avx2::lanes;

#[path = "operations.rs"]
mod operations;
