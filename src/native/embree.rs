//! Bindings to Embree 4, which is loaded at run time. The build neither needs nor links it.
//!
//! Only the functions that the benchmark calls are declared, after Embree's public headers
//! (rtcore.h of version 4).

use std::{
    ffi::{CString, c_char, c_int, c_uint, c_void},
    path::Path,
    ptr,
    time::{Duration, Instant},
};

use super::library::{LoadError, NativeLibrary};
use crate::math::{Ray, Vec3};

/// The quality of Embree's build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmbreeQuality {
    Low = 0,
    Medium = 1,
    High = 2,
}

/// Whether the rays of a packet have nearby origins and similar directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coherence {
    Coherent,
    Incoherent,
}

/// The reason why Embree cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum EmbreeError {
    #[error("cannot load Embree")]
    Load(#[from] LoadError),
    #[error("Embree gives no device")]
    Device,
}

/// The functions of the library.
struct Functions {
    new_device: unsafe extern "C" fn(*const c_char) -> *mut c_void,
    release_device: unsafe extern "C" fn(*mut c_void),
    new_scene: unsafe extern "C" fn(*mut c_void) -> *mut c_void,
    release_scene: unsafe extern "C" fn(*mut c_void),
    set_quality: unsafe extern "C" fn(*mut c_void, c_int),
    commit_scene: unsafe extern "C" fn(*mut c_void),
    new_geometry: unsafe extern "C" fn(*mut c_void, c_int) -> *mut c_void,
    release_geometry: unsafe extern "C" fn(*mut c_void),
    new_buffer: unsafe extern "C" fn(*mut c_void, c_int, c_uint, c_int, usize, usize) -> *mut c_void,
    commit_geometry: unsafe extern "C" fn(*mut c_void),
    attach_geometry: unsafe extern "C" fn(*mut c_void, *mut c_void) -> c_uint,
    intersect1: unsafe extern "C" fn(*mut c_void, *mut RayHit, *mut Arguments),
    occluded1: unsafe extern "C" fn(*mut c_void, *mut RayHit, *mut Arguments),
    intersect16: unsafe extern "C" fn(*const c_int, *mut c_void, *mut RayHit16, *mut Arguments),
    occluded16: unsafe extern "C" fn(*const c_int, *mut c_void, *mut RayHit16, *mut Arguments),
}

impl Functions {
    fn load(library: &NativeLibrary) -> Result<Self, EmbreeError> {
        macro_rules! function {
            ($name:literal) => {
                // SAFETY: the declared type is that of the function of this name in Embree 4's headers.
                unsafe { library.function($name)? }
            };
        }
        Ok(Self {
            new_device: function!("rtcNewDevice"),
            release_device: function!("rtcReleaseDevice"),
            new_scene: function!("rtcNewScene"),
            release_scene: function!("rtcReleaseScene"),
            set_quality: function!("rtcSetSceneBuildQuality"),
            commit_scene: function!("rtcCommitScene"),
            new_geometry: function!("rtcNewGeometry"),
            release_geometry: function!("rtcReleaseGeometry"),
            new_buffer: function!("rtcSetNewGeometryBuffer"),
            commit_geometry: function!("rtcCommitGeometry"),
            attach_geometry: function!("rtcAttachGeometry"),
            intersect1: function!("rtcIntersect1"),
            occluded1: function!("rtcOccluded1"),
            intersect16: function!("rtcIntersect16"),
            occluded16: function!("rtcOccluded16"),
        })
    }
}

/// RTCRay and RTCHit. The hit has room for the instance fields of every minor version.
#[repr(C, align(16))]
#[derive(Clone, Copy)]
pub struct RayHit {
    o: [f32; 3],
    tnear: f32,
    d: [f32; 3],
    time: f32,
    tfar: f32,
    mask: u32,
    id: u32,
    flags: u32,
    ng: [f32; 3],
    uv: [f32; 2],
    prim: u32,
    geometry: u32,
    instance: [u32; 5],
}

/// RTCRay16 and RTCHit16.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
pub struct RayHit16 {
    o: [[f32; 16]; 3],
    tnear: [f32; 16],
    d: [[f32; 16]; 3],
    time: [f32; 16],
    tfar: [f32; 16],
    mask: [u32; 16],
    id: [u32; 16],
    flags: [u32; 16],
    ng: [[f32; 16]; 3],
    uv: [[f32; 16]; 2],
    prim: [u32; 16],
    geometry: [u32; 16],
    instance: [[u32; 16]; 5],
}

/// RTCIntersectArguments and RTCOccludedArguments, which are laid out alike.
#[repr(C)]
struct Arguments {
    flags: u32,
    features: u32,
    context: *mut c_void,
    filter: *const c_void,
    function: *const c_void,
}

impl Arguments {
    fn new(coherence: Coherence) -> Self {
        Self {
            flags: match coherence {
                Coherence::Coherent => COHERENT,
                Coherence::Incoherent => 0,
            },
            features: u32::MAX,
            context: ptr::null_mut(),
            filter: ptr::null(),
            function: ptr::null(),
        }
    }
}

/// RTC_RAY_QUERY_FLAG_COHERENT.
const COHERENT: u32 = 1 << 16;
/// RTC_GEOMETRY_TYPE_TRIANGLE, RTC_BUFFER_TYPE_INDEX and _VERTEX, RTC_FORMAT_UINT3 and _FLOAT3.
const TRIANGLE: c_int = 0;
const INDEX: c_int = 0;
const VERTEX: c_int = 1;
const UINT3: c_int = 0x5003;
const FLOAT3: c_int = 0x9003;
const INVALID: u32 = u32::MAX;

#[repr(align(64))]
struct Valid([c_int; 16]);

/// A scene of triangles in Embree.
pub struct Embree {
    functions: Functions,
    device: *mut c_void,
    scene: *mut c_void,
    pub build_time: Duration,
}

// SAFETY: a committed scene is only read, which Embree allows from any number of threads at once.
unsafe impl Sync for Embree {}
// SAFETY: Embree's objects belong to no thread.
unsafe impl Send for Embree {}

impl Embree {
    /// Loads the library at `path` and builds a scene of triangles.
    pub fn build(
        path: &Path,
        vertices: &[Vec3],
        triangles: &[[u32; 3]],
        quality: EmbreeQuality,
        threads: usize,
    ) -> Result<Self, EmbreeError> {
        let library = NativeLibrary::load(path)?;
        let functions = Functions::load(&library)?;
        let config = CString::new(format!("threads={threads},set_affinity=0")).expect("no zero byte in it");
        // SAFETY: the configuration is a string that ends in a zero byte.
        let device = unsafe { (functions.new_device)(config.as_ptr()) };
        if device.is_null() {
            return Err(EmbreeError::Device);
        }
        // SAFETY: the device is valid, and every handle below comes from it. The buffers belong to
        // Embree, have the requested size and format, and are filled completely before they are
        // committed.
        let (scene, build_time) = unsafe {
            let scene = (functions.new_scene)(device);
            (functions.set_quality)(scene, quality as c_int);
            let mesh = (functions.new_geometry)(device, TRIANGLE);
            let buffer = (functions.new_buffer)(mesh, VERTEX, 0, FLOAT3, 12, vertices.len());
            ptr::copy_nonoverlapping(vertices.as_ptr().cast::<u8>(), buffer.cast(), size_of_val(vertices));
            let buffer = (functions.new_buffer)(mesh, INDEX, 0, UINT3, 12, triangles.len());
            ptr::copy_nonoverlapping(triangles.as_ptr().cast::<u8>(), buffer.cast(), size_of_val(triangles));
            (functions.commit_geometry)(mesh);
            (functions.attach_geometry)(scene, mesh);
            (functions.release_geometry)(mesh);
            let start = Instant::now();
            (functions.commit_scene)(scene);
            (scene, start.elapsed())
        };
        Ok(Self {
            functions,
            device,
            scene,
            build_time,
        })
    }

    /// Traces one ray per call.
    pub fn trace_single(&self, occlusion: bool, queries: &mut [RayHit]) {
        let call = if occlusion {
            self.functions.occluded1
        } else {
            self.functions.intersect1
        };
        for query in queries {
            // SAFETY: the scene is committed, a query has the layout of RTCRayHit (of which an occlusion test reads
            // the ray), and null arguments stand for the defaults.
            unsafe { call(self.scene, query, ptr::null_mut()) };
        }
    }

    /// Traces sixteen rays per call, with a hint about their coherence.
    pub fn trace_packets(&self, occlusion: bool, coherence: Coherence, queries: &mut [RayHit16]) {
        let call = if occlusion {
            self.functions.occluded16
        } else {
            self.functions.intersect16
        };
        let mut arguments = Arguments::new(coherence);
        let valid = Valid([-1; 16]);
        for query in queries {
            // SAFETY: as above; the mask and the packet are aligned to 64 bytes as Embree wants them.
            unsafe { call(valid.0.as_ptr(), self.scene, query, &mut arguments) };
        }
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: both were made by `build` and are released once.
        unsafe {
            (self.functions.release_scene)(self.scene);
            (self.functions.release_device)(self.device);
        }
    }
}

/// Returns the distance that Embree found: infinite for a miss, -1 for an occlusion.
fn answer(occlusion: bool, tfar: f32, geometry: u32) -> f32 {
    match occlusion {
        // Embree marks an occluded ray by a `tfar` of minus infinity.
        true if tfar < 0.0 => -1.0,
        false if geometry != INVALID => tfar,
        _ => f32::INFINITY,
    }
}

impl RayHit {
    pub fn new(ray: &Ray) -> Self {
        Self {
            o: ray.o.to_array(),
            tnear: ray.tmin,
            d: ray.d.to_array(),
            time: 0.0,
            tfar: ray.tmax,
            mask: u32::MAX,
            id: 0,
            flags: 0,
            ng: [0.0; 3],
            uv: [0.0; 2],
            prim: INVALID,
            geometry: INVALID,
            instance: [INVALID; 5],
        }
    }

    pub fn distance(&self, occlusion: bool) -> f32 {
        answer(occlusion, self.tfar, self.geometry)
    }
}

impl RayHit16 {
    /// Packs at most 16 rays; unused lanes repeat the first one.
    pub fn new(rays: &[Ray]) -> Self {
        let lane = |f: &dyn Fn(&Ray) -> f32| std::array::from_fn(|k| f(rays.get(k).unwrap_or(&rays[0])));
        let axes = |f: fn(&Ray) -> [f32; 3]| std::array::from_fn(|axis| lane(&|r| f(r)[axis]));
        Self {
            o: axes(|r| r.o.to_array()),
            tnear: lane(&|r| r.tmin),
            d: axes(|r| r.d.to_array()),
            time: [0.0; 16],
            tfar: lane(&|r| r.tmax),
            mask: [u32::MAX; 16],
            id: [0; 16],
            flags: [0; 16],
            ng: [[0.0; 16]; 3],
            uv: [[0.0; 16]; 2],
            prim: [INVALID; 16],
            geometry: [INVALID; 16],
            instance: [[INVALID; 16]; 5],
        }
    }

    pub fn distance(&self, lane: usize, occlusion: bool) -> f32 {
        answer(occlusion, self.tfar[lane], self.geometry[lane])
    }
}
