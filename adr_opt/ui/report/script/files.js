// Files that the page makes where they are asked for.
function offer(content, kind, ending) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([content], { type: kind }));
  link.download = `${document.querySelector("h1").textContent.replace(/[^\w.-]+/g, "-")}-${ending}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

const CRC = Uint32Array.from({ length: 256 }, (_, byte) => {
  let rest = byte;
  for (let bit = 0; bit < 8; bit += 1) rest = rest & 1 ? (rest >>> 1) ^ 0xedb88320 : rest >>> 1;
  return rest;
});

function checksum(bytes) {
  let rest = 0xffffffff;
  for (const byte of bytes) rest = CRC[(rest ^ byte) & 0xff] ^ (rest >>> 8);
  return (rest ^ 0xffffffff) >>> 0;
}

// Numbers of two bytes, and of four where they are given as [number].
function header(...numbers) {
  return Uint8Array.from(numbers.flatMap((number) => {
    const [value, count] = Array.isArray(number) ? [number[0], 4] : [number, 2];
    return Array.from({ length: count }, (_, at) => (value >>> (8 * at)) & 0xff);
  }));
}

// A ZIP archive of files, { name, bytes }, as they are: pictures are compressed already.
function archive(files) {
  const DATE = 0x21; // the first day that the format knows
  const parts = [];
  const directory = [];
  let place = 0;
  for (const { name, bytes } of files) {
    const title = new TextEncoder().encode(name);
    const about = [20, 0x800, 0, 0, DATE, [checksum(bytes)], [bytes.length], [bytes.length],
      title.length, 0];
    const before = header([0x04034b50], ...about);
    parts.push(before, title, bytes);
    directory.push(header([0x02014b50], 20, ...about, 0, 0, 0, [0], [place]), title);
    place += before.length + title.length + bytes.length;
  }
  const long = directory.reduce((sum_, part_) => sum_ + part_.length, 0);
  const end = header([0x06054b50], 0, 0, files.length, files.length, [long], [place], 0);
  return new Blob([...parts, ...directory, end]);
}
