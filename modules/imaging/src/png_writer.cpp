// png_writer
